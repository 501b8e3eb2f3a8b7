"""Lines, circles and text at fractions of a pixel; what is far outside the picture is not drawn."""

from __future__ import annotations

import cv2
import numpy as np

from followspot.messages import Array

Color = tuple[int, int, int]
"""BGR."""
FONT = cv2.FONT_HERSHEY_SIMPLEX
FRACTION = 4
"""Binary places of coordinates that OpenCV draws with."""
FARTHEST = 1 << 14
"""Pixels beyond which nothing is drawn."""


def polyline(picture: Array, points: Array, color: Color) -> None:
    """Lines through (K, 2) px."""
    if (np.abs(points) < FARTHEST).all():
        at = np.rint(points * 2**FRACTION).astype("i4")[:, None]
        cv2.polylines(picture, [at], False, color, 1, cv2.LINE_AA, FRACTION)


def label(picture: Array, at: Array, text: str, color: Color) -> None:
    """Text with a dark rim, from its lower left corner (2,) px."""
    if visible(picture, at):
        cv2.putText(picture, text, whole(at), FONT, 0.42, (0, 0, 0), 3, cv2.LINE_AA)
        cv2.putText(picture, text, whole(at), FONT, 0.42, color, 1, cv2.LINE_AA)


def visible(picture: Array, at: Array) -> bool:
    """Whether a point (2,) px is in the picture or near it."""
    height, width = picture.shape[:2]
    return bool(-width < at[0] < 2 * width and -height < at[1] < 2 * height)


def whole(at: Array) -> tuple[int, int]:
    """The nearest pixel."""
    return round(float(at[0])), round(float(at[1]))


def fixed(at: Array) -> tuple[int, int]:
    """Coordinates as OpenCV draws them."""
    return whole(at * 2**FRACTION)


def circle(picture: Array, center: Array, radius: float, color: Color, thickness: int = 1) -> None:
    """A circle around (2,) px if its centre is in the picture or near it."""
    if visible(picture, center) and radius < FARTHEST:
        scaled = round(radius * 2**FRACTION)
        cv2.circle(picture, fixed(center), scaled, color, thickness, cv2.LINE_AA, FRACTION)
