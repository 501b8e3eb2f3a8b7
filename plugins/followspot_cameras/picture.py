"""Conversion of decoded pictures to a `Frame`: the camera's size and number of channels in one array."""

from __future__ import annotations

from collections.abc import Callable

import cv2

from followspot.errors import InputError, Mistake
from followspot.messages import Array
from followspot.room import Camera
from followspot.tracking import Frame

Loan = Callable[[tuple[int, ...], str], Array]


def color_buffer(camera: Camera, loan: Loan) -> Array | None:
    """(H, W, 3) to decode into, if the picture needs no conversion afterwards; else None."""
    width, height = camera.size
    return loan((height, width, 3), "u1") if camera.kind == "color" else None


def as_frame(image: Array, camera: Camera, loan: Loan, origin: str) -> Frame:
    """The decoded picture as the camera's frame: BGR for colour cameras, one grey channel for infrared.

    image: (H, W, 3) BGR or (H, W) grey; origin: file, device or address, for the error.
    Raises InputError if the size is not that of the calibration.
    """
    check_size(image.shape[1], image.shape[0], camera, origin)
    gray = image.ndim == 2 or image.shape[2] == 1
    if camera.kind == "color":
        pixels = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if gray else image
        return Frame(camera=camera.name, pixels=pixels)
    if gray:
        return Frame(camera=camera.name, pixels=image.reshape(*image.shape[:2], 1))
    pixels = loan((*image.shape[:2], 1), "u1")
    cv2.cvtColor(image, cv2.COLOR_BGR2GRAY, dst=pixels)
    return Frame(camera=camera.name, pixels=pixels)


def check_size(width: int, height: int, camera: Camera, origin: str) -> None:
    """Raise InputError if a picture does not have the size, px, that the camera was calibrated with."""
    if (width, height) != camera.size:
        raise InputError(
            [
                Mistake(
                    None,
                    f"{origin} has pictures of {width}x{height} px, "
                    f"but camera {camera.name} is calibrated for {camera.size[0]}x{camera.size[1]} px",
                    "give the camera its own recording, or calibrate it at this size",
                )
            ]
        )
