"""A picture of a machine-vision camera as a `Frame`."""

from __future__ import annotations

from followspot.errors import InputError, Mistake
from followspot.room import Camera
from followspot.tracking import Frame
from followspot_cameras.genicam.camera import Picture
from followspot_cameras.picture import Loan, check_size
from followspot_cameras.pixel_formats import UnknownFormat, as_bgr, as_gray, eight_bits


def as_frame(picture: Picture, camera: Camera, loan: Loan, origin: str) -> Frame:
    """The picture as the camera's frame, converted into a loaned array.

    Raises InputError if the size is not that of the calibration, or the pixel format cannot be read.
    """
    width, height = picture.size
    check_size(width, height, camera, origin)
    try:
        raw = eight_bits(picture.data, picture.size, picture.format)
        if camera.kind == "color":
            pixels = as_bgr(raw, picture.format, loan((height, width, 3), "u1"))
        else:
            pixels = as_gray(raw, picture.format, loan((height, width, 1), "u1"))
    except (UnknownFormat, ValueError) as error:
        text = f"{origin}: {error}"
        raise InputError([Mistake(None, text, "see `followspot cameras` for what it offers")]) from None
    return Frame(camera=camera.name, pixels=pixels)
