"""Corners of a marker as intersections of its sides, which are measured along their whole length.

A corner measured by itself is pulled inwards by the blur of a picture, by a quarter of a pixel and more; a
marker of 30 pixels in one camera then is almost two percent too far away.
"""

from __future__ import annotations

import cv2
import numpy as np

from followspot.geometry import distort, undistort
from followspot.messages import Array
from followspot.room import Camera

ALONG = np.linspace(0.12, 0.88, 24)
"""Places along a side at which it is measured."""
REACH = 0.14
"""How far from a side it is looked for, over the width of the marker; its border is a sixth of it or less."""
NEAREST, FARTHEST = 2.0, 8.0
"""Limits of that, px."""
STEP = 0.25
"""Distance of samples across a side, px."""
RISE = 4
"""Samples over which the steepest rise is looked for."""
BLUR, LEAST_BLUR, MOST_BLUR = 0.08, 3, 7
"""How far on both sides of it an edge is blurred, over the width of the marker, and limits in samples."""
LEAST_CONTRAST = 20.0
"""Grey levels between both sides of an edge."""
LEAST_PLACES = 8
"""Places at which a side must be measured."""
ROUNDS = 3
FARTHEST_MOVE = 3.0
"""Largest distance of a corner from where it was found, px."""


def edge_corners(camera: Camera, gray: Array, corners: Array) -> Array:
    """The corners of one marker, (4, 2) px in the picture; as they were found if a side cannot be measured.

    gray: (H, W) uint8; corners: (4, 2) px, clockwise. Sides are straight without the lens distortion.
    """
    moved = corners
    for _ in range(ROUNDS):
        area = float(cv2.contourArea(moved.astype(np.float32)))
        sides = (_side(camera, gray, moved[k], moved[(k + 1) % 4], area) for k in range(4))
        lines = [side for side in sides if side is not None]
        if len(lines) < 4:
            return corners
        xy = np.array([_crossing(lines[k - 1], lines[k]) for k in range(4)])
        if not np.isfinite(xy).all():
            return corners
        moved = distort(camera, xy)
        if not (np.abs(moved - corners) < FARTHEST_MOVE).all():
            return corners
    return moved


def _side(camera: Camera, gray: Array, start: Array, end: Array, area: float) -> tuple[Array, Array] | None:
    """A point of a side and its direction, px without distortion; None if it cannot be measured.

    area: of the marker, px; over the side's length it is its width across that side.
    """
    way = end - start
    length = float(np.hypot(*way))
    if length < 4 * NEAREST:
        return None
    outward = np.array([way[1], -way[0]]) / length
    width = area / length
    reach = min(max(REACH * width, NEAREST), FARTHEST)
    blur = int(min(max(BLUR * width / STEP, LEAST_BLUR), MOST_BLUR))
    across = np.arange(-reach, reach + STEP / 2, STEP)
    base = start + ALONG[:, None] * way
    sampled = (base[:, None] + across[:, None] * outward).astype(np.float32)
    level = cv2.remap(
        gray, sampled[..., 0], sampled[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    level = level.astype(float)
    steepest = (level[:, RISE:] - level[:, :-RISE]).argmax(axis=1) + RISE // 2
    first = np.clip(steepest - blur, 0, len(across) - 2 * blur - 1)
    near = np.take_along_axis(level, first[:, None] + np.arange(2 * blur + 1), axis=1)
    dark, bright = near[:, :2].mean(axis=1), near[:, -2:].mean(axis=1)
    clear = bright - dark > LEAST_CONTRAST
    if np.count_nonzero(clear) < LEAST_PLACES:
        return None
    share = (near[clear] - dark[clear, None]) / (bright - dark)[clear, None]
    last = across[first[clear] + 2 * blur]
    edge = last + STEP / 2 - STEP * share.sum(axis=1)  # where a step would have as much light
    points = undistort(camera, base[clear] + edge[:, None] * outward)
    if not np.isfinite(points).all():
        return None
    x, y, px, py = cv2.fitLine(points.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01).ravel().astype(float)
    return np.array([px, py]), np.array([x, y])


def _crossing(one: tuple[Array, Array], other: tuple[Array, Array]) -> Array:
    """The intersection of two lines, (2,) px; infinite if they are parallel."""
    (p, u), (q, v) = one, other
    turn = u[0] * v[1] - u[1] * v[0]
    if abs(turn) < 1e-6:
        return np.full(2, np.inf)
    offset = q - p
    return np.asarray(p + (offset[0] * v[1] - offset[1] * v[0]) / turn * u)
