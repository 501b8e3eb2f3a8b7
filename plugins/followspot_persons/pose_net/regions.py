"""Parts of pictures in the size that a network takes, and the way back to the picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from followspot import Array
from followspot_persons.body.standing import WAIST
from followspot_persons.body.upper_body_box import HIP

LONGEST = 2560
"""Longest side of an image, px; longer images are reduced further."""
SMALLEST = 8
"""Shortest side of a part of a picture, px."""
AROUND = 1.3
"""Side of the square about a person, in body heights: the circle about the hips that holds an upright body,
and a quarter more, as MediaPipe cuts it."""


@dataclass(frozen=True)
class Region:
    """A part of a picture, which may lie beyond its border, and the image that it becomes.

    left, top, width, height: of the part, px of the picture; filled: width and height in the image, px; size:
    of the image, whose rest is black on the right and below.
    """

    left: int
    top: int
    width: int
    height: int
    filled: tuple[int, int]
    size: tuple[int, int]

    def cut(self, pixels: Array) -> Array:
        """The image, (H, W, C) u8, of a picture (H, W, C) u8."""
        height, width = pixels.shape[:2]
        x0, x1 = np.clip([self.left, self.left + self.width], 0, width).tolist()
        y0, y1 = np.clip([self.top, self.top + self.height], 0, height).tolist()
        part = np.zeros((self.height, self.width, pixels.shape[2]), np.uint8)
        part[y0 - self.top : y1 - self.top, x0 - self.left : x1 - self.left] = pixels[y0:y1, x0:x1]
        shrinks = self.filled[0] < self.width
        kind = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        image = np.zeros((self.size[1], self.size[0], pixels.shape[2]), np.uint8)
        image[: self.filled[1], : self.filled[0]] = cv2.resize(part, self.filled, interpolation=kind)
        return image

    def moved(self, columns: int) -> Region:
        """The same part of a picture with so many columns more on the left."""
        return replace(self, left=self.left + columns)

    def in_picture(self, pixel: Array) -> Array:
        """Places in the image, (..., 2) px, in the picture, px."""
        scale = np.array([self.width, self.height]) / np.array(self.filled)
        return np.asarray((pixel + 0.5) * scale - 0.5 + np.array([self.left, self.top]))


def whole(width: int, height: int, side: int, multiple: int, size: tuple[int, int] | None) -> Region:
    """A whole picture. side: its shorter side in the image, px; size: of the image, if there is no choice."""
    if size is not None:
        scale = min(size[0] / width, size[1] / height)
    else:
        scale = min(side / min(width, height), LONGEST / max(width, height))
    filled = max(1, round(width * scale)), max(1, round(height * scale))
    if size is None:
        size = -(-filled[0] // multiple) * multiple, -(-filled[1] // multiple) * multiple
    return Region(0, 0, width, height, filled, size)


def about(box: Array, picture: tuple[int, int], size: tuple[int, int]) -> Region | None:
    """The square about the person with this upper body (4,) px; None if the picture cannot show it.

    picture: width and height, px; size: of the image.
    """
    x0, y0, x1, y1 = box.tolist()
    body = (y1 - y0) / (1 - WAIST)
    side = AROUND * body
    if not (np.isfinite(box).all() and SMALLEST <= side <= 4 * max(picture)):
        return None
    middle, hips = (x0 + x1) / 2, y0 + (1 - HIP) * body
    if not (-side / 2 < middle < picture[0] + side / 2 and -side / 2 < hips < picture[1] + side / 2):
        return None
    length = round(side)
    return Region(round(middle - side / 2), round(hips - side / 2), length, length, size, size)
