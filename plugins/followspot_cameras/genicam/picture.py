"""A picture of a machine-vision camera as a `Frame`."""

from __future__ import annotations

from followspot.errors import InputError, Mistake
from followspot.room import Camera
from followspot.tracking import Frame
from followspot_cameras.genicam.camera import Picture
from followspot_cameras.picture import Loan, check_size
from followspot_cameras.pixel_formats import UnknownFormat, converted, line_bytes


def as_frame(picture: Picture, camera: Camera, loan: Loan, origin: str) -> Frame:
    """The picture as the camera's frame, converted into a loaned array.

    Raises InputError if the size is not that of the calibration, or the pixel format cannot be read.
    """
    width, height = picture.size
    check_size(width, height, camera, origin)
    name, channels = picture.format, 3 if camera.kind == "color" else 1
    try:
        line = line_bytes(name, width) + picture.padding
        pixels = converted(picture.data, picture.size, name, loan((height, width, channels), "u1"), line)
    except (UnknownFormat, ValueError) as error:
        text = f"{origin}: {error}"
        raise InputError([Mistake(None, text, "see `followspot cameras` for what it offers")]) from None
    return Frame(camera=camera.name, pixels=pixels)
