"""A preview of a frame or of a depth image: smaller, and compressed."""

from __future__ import annotations

import cv2

from followspot import Message
from followspot.messages import Array, column, stamped
from followspot.tracking import DepthImage, Frame
from followspot_dashboard.depth_colors import depth_picture

QUALITY = 70
"""Quality of the JPEG, of 100."""
FARTHEST = 8.0
"""Depth that has the last colour, m, if none is given."""
PICTURES = (Frame, DepthImage)
"""Message types that are shown as pictures."""


class Picture(Message):
    """A frame, or a depth image in colours, as a small JPEG. width, height: of the message itself, px."""

    camera: str
    width: int
    height: int
    jpeg: Array = column("B", dtype="u1")


def picture_of(message: Frame | DepthImage, longest: int, farthest: float = FARTHEST) -> Picture | None:
    """The preview of a message; None for one without pixels, or with neither one nor three channels.

    longest: its longest side, px; farthest: depth that has the last colour, m.
    """
    pixels = message.depth if isinstance(message, DepthImage) else message.pixels
    height, width = pixels.shape[:2]
    if not (height and width) or pixels.shape[2:] not in ((), (1,), (3,)):
        return None
    scale = longest / max(height, width)
    if scale < 1.0:
        size = max(1, round(width * scale)), max(1, round(height * scale))
        whole = isinstance(
            message, DepthImage
        )  # a mean of two depths, or of one and none, is a depth of nothing
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_NEAREST if whole else cv2.INTER_AREA)
    if isinstance(message, DepthImage):
        pixels = depth_picture(pixels, farthest)
    ok, jpeg = cv2.imencode(".jpg", pixels, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
    picture = Picture(message.camera, width, height, jpeg.reshape(-1))
    return stamped(picture, message.header) if ok else None
