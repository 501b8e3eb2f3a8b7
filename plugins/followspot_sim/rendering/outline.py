"""Stadiums, the outlines of capsules and strokes, as convex polygons; and how they are filled."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array

SUBPIXEL = 4
"""Binary digits after the point in coordinates that are handed to OpenCV."""
FAN = np.linspace(-np.pi / 2, np.pi / 2, 7)
"""Directions of the corners of a round end, rad from the axis."""
WIDEN = np.sqrt(np.pi / (6 * np.sin(FAN[1] - FAN[0])))
"""By how much corners stand out of the circle, so that the dodecagon has its area."""
ALONG, ACROSS = WIDEN * np.cos(FAN)[:, None], WIDEN * np.sin(FAN)[:, None]
CORNERS = 2 * len(FAN)


def stadiums(ends: Array, radius: Array) -> Array:
    """Outlines of segments with round ends; segments of no length become discs.

    ends: (N, 2, 2); radius: (N, 2) at each end. Returns (N, 14, 2), in the same unit.
    """
    axis = ends[:, 1] - ends[:, 0]
    length = np.sqrt(axis[:, 0] * axis[:, 0] + axis[:, 1] * axis[:, 1])
    forward = axis / np.maximum(length, 1e-9)[:, None]
    forward[length < 1e-9] = (1.0, 0.0)
    side = forward[:, ::-1] * (-1.0, 1.0)
    fan = forward[:, None] * ALONG + side[:, None] * ACROSS
    polygon = np.empty((len(ends), CORNERS, 2))
    np.multiply(fan, radius[:, 1, None, None], out=polygon[:, : len(FAN)])
    np.multiply(fan, -radius[:, 0, None, None], out=polygon[:, len(FAN) :])
    polygon[:, : len(FAN)] += ends[:, 1, None]
    polygon[:, len(FAN) :] += ends[:, 0, None]
    return polygon


def fixed_point(polygon: Array) -> Array:
    """Coordinates in px as OpenCV's drawing takes them."""
    return np.asarray(np.rint(polygon * (1 << SUBPIXEL)).astype(np.int32))


def fill(image: Array, polygon: Array, tone: list[float] | int, soft: bool = True) -> None:
    """Fill one polygon of :func:`fixed_point`; a soft edge takes twice the time."""
    kind = cv2.LINE_AA if soft else cv2.LINE_8
    cv2.fillConvexPoly(image, polygon, tone, kind, SUBPIXEL)


def spot(image: Array, centre: list[float], radius: float, tone: list[float]) -> None:
    """A small disc between pixels; centre and radius in px."""
    x, y, r = (round(v * (1 << SUBPIXEL)) for v in (*centre, radius))
    cv2.circle(image, (x, y), r, tone, -1, cv2.LINE_AA, SUBPIXEL)
