"""A preview of a frame: smaller, and compressed."""

from __future__ import annotations

import cv2

from followspot import Message
from followspot.messages import Array, column, stamped
from followspot.tracking import Frame

QUALITY = 70
"""Quality of the JPEG, of 100."""


class Picture(Message):
    """A frame as a small JPEG. width, height: of the frame itself, px."""

    camera: str
    width: int
    height: int
    jpeg: Array = column("B", dtype="u1")


def picture_of(frame: Frame, longest: int) -> Picture | None:
    """The preview of a frame; longest: its longest side, px. None for a frame without pixels."""
    height, width, channels = frame.pixels.shape
    if not (height and width) or channels not in (1, 3):
        return None
    pixels = frame.pixels
    scale = longest / max(height, width)
    if scale < 1.0:
        size = max(1, round(width * scale)), max(1, round(height * scale))
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    ok, jpeg = cv2.imencode(".jpg", pixels, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
    picture = Picture(frame.camera, width, height, jpeg.reshape(-1))
    return stamped(picture, frame.header) if ok else None
