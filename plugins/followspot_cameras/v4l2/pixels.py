"""Pictures of V4L2 devices as grey or BGR."""

from __future__ import annotations

import cv2
import numpy as np

from followspot.messages import Array
from followspot.room import Camera
from followspot.tracking import Frame
from followspot_cameras.picture import Loan, as_frame, color_buffer
from followspot_cameras.pixel_formats import converted

UNPACKED = {
    "YUYV": "YUV422_8",
    "UYVY": "YUV422_8_UYVY",
    "BGR3": "BGR8",
    "RGB3": "RGB8",
    "GREY": "Mono8",
    "Y10 ": "Mono10",
    "Y12 ": "Mono12",
    "Y16 ": "Mono16",
    "RGGB": "BayerRG8",
    "GRBG": "BayerGR8",
    "GBRG": "BayerGB8",
    "BA81": "BayerBG8",
}
"""Pixel formats of V4L2, and their names by the Pixel Format Naming Convention."""
PLANAR = {
    "NV12": cv2.COLOR_YUV2BGR_NV12,
    "NV21": cv2.COLOR_YUV2BGR_NV21,
    "YU12": cv2.COLOR_YUV2BGR_I420,
    "YV12": cv2.COLOR_YUV2BGR_YV12,
}
"""Formats with a plane of grey and a quarter of it twice for the colours."""
COMPRESSED = ("MJPG", "JPEG")
READ = (*UNPACKED, *PLANAR, *COMPRESSED)
"""Formats that can be read, those first that cost least."""


class Damaged(ValueError):
    """A picture that cannot be decoded, or has too few bytes."""


def frame_of(data: Array, fourcc: str, line: int, camera: Camera, loan: Loan, origin: str) -> Frame:
    """The picture as the camera's frame, converted into a loaned array.

    data: (B,) uint8, of the camera's size; line: bytes from one line to the next, 0 if they are not told.
    Raises Damaged; InputError for a compressed picture of another size.
    """
    if fourcc in UNPACKED:
        return _converted(data, UNPACKED[fourcc], line, camera, loan)
    if fourcc in PLANAR:
        return as_frame(_planes(data, fourcc, line, camera, loan), camera, loan, origin)
    decoded = cv2.imdecode(data, cv2.IMREAD_COLOR) if len(data) else None
    if decoded is None:
        raise Damaged("it cannot be decoded")
    return as_frame(np.asarray(decoded), camera, loan, origin)


def _converted(data: Array, name: str, line: int, camera: Camera, loan: Loan) -> Frame:
    width, height = camera.size
    channels = 3 if camera.kind == "color" else 1
    try:
        pixels = converted(data, camera.size, name, loan((height, width, channels), "u1"), line)
    except ValueError as error:
        raise Damaged(str(error)) from None
    return Frame(camera=camera.name, pixels=pixels)


def _planes(data: Array, fourcc: str, line: int, camera: Camera, loan: Loan) -> Array:
    """The picture in colour, (H, W, 3). Raises Damaged."""
    width, height = camera.size
    if line > width:
        raise Damaged(f"lines of {line} bytes for {width} px are not read in {fourcc}")
    if len(data) < width * height * 3 // 2:
        raise Damaged(f"the picture has {len(data)} of {width * height * 3 // 2} bytes")
    planes = data[: width * height * 3 // 2].reshape(height * 3 // 2, width)
    return np.asarray(cv2.cvtColor(planes, PLANAR[fourcc], dst=color_buffer(camera, loan)))
