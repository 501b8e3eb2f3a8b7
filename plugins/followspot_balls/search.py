"""Where a target is looked for: circles in the views (Jin & Qian 2008, eq. 3) and spheres in the room."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera
from followspot.tracking import LOST, TRACKED, Forecast

WINDOW = 1.5
"""Balls' radii by which a window exceeds its search circle."""
TINY = np.finfo(float).tiny


class Circles(NamedTuple):
    """Search regions of one view, a row for each target."""

    center: Array
    """(T, 2) px, as in the picture; NaN behind the camera and for lost targets."""
    radius: Array
    """(T,) px."""
    ball: Array
    """(T,) px, radius of the target's outline; NaN where the centre is."""
    lost: Array
    """(T,) bool: looked for in the whole image."""


def lost_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets have no forecast: all, before the first one. Returns (T,) bool."""
    if forecast is None or len(forecast.state) != count:
        return np.ones(count, bool)
    return np.asarray(forecast.state == LOST)


def tracked_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets were measured in the frame before; none, at first. Returns (T,) bool."""
    if forecast is None or len(forecast.state) != count:
        return np.zeros(count, bool)
    return np.asarray(forecast.state == TRACKED)


def search_radius(travel: Array, minimum: float, scale: float) -> Array:
    """T_2D: `minimum` while the expected travel is at most that, else `scale` times the travel (eq. 3).

    travel: (...,) px between the last two estimates, NaN where one has no image; minimum: px.
    """
    return np.asarray(np.where(travel > minimum, scale * travel, minimum))


def search_circles(
    camera: Camera, forecast: Forecast | None, sizes: Array, minimum: float, scale: float
) -> Circles:
    """Circles around the forecasts reprojected into one view (section 3.3), and the balls in them.

    sizes: (T,) radii of the targets, m; minimum: px.
    """
    count = len(sizes)
    lost = lost_targets(forecast, count)
    if forecast is None or lost.all():
        nowhere = np.full((count, 2), np.nan)
        return Circles(nowhere, np.full(count, minimum), nowhere[:, 0], lost)
    xyz = forecast.xyz
    sides = (xyz + camera.rotation[:2, None] * sizes[:, None]).reshape(-1, 3)
    pixel = project(camera, np.concatenate([xyz, forecast.last, forecast.before, sides]))
    center = pixel[:count]
    center[lost] = np.nan
    last, before, right, down = pixel[count:].reshape(4, count, 2)
    travel = search_radius(length(last - before), minimum, scale)
    across = (length(right - center) + length(down - center)) / 2
    return Circles(center, travel, across * elongation(camera, xyz), lost)


def elongation(camera: Camera, xyz: Array) -> Array:
    """Mean semi-axis of a sphere's outline over that across the axis, (T,).

    A sphere seen at an angle a from the optical axis looks 1 / cos a longer towards it than across.
    """
    direction = xyz - camera.center
    cosine = direction @ camera.rotation[2] / np.sqrt(np.einsum("ij,ij->i", direction, direction) + TINY)
    return np.asarray((1 + 1 / np.maximum(cosine, 0.1)) / 2)


def length(vectors: Array) -> Array:
    """(N, 2) -> (N,)."""
    return np.asarray(np.hypot(vectors[:, 0], vectors[:, 1]))


def within(circles: Circles, pixel: Array) -> Array:
    """Which points lie in which target's search region: (N, 2) px -> (N, T) bool; in a lost one's all do."""
    offset = pixel[:, None] - circles.center
    inside = np.einsum("nti,nti->nt", offset, offset) <= np.square(circles.radius)
    return np.asarray(inside | circles.lost)


def in_picture(circles: Circles, size: tuple[int, int]) -> Array:
    """Targets whose search region reaches into a picture of this width and height, px: their numbers."""
    inside = (circles.center >= -circles.radius[:, None]) & (circles.center <= size + circles.radius[:, None])
    return np.flatnonzero(inside.all(axis=1))


def windows(circles: Circles, chosen: Array, size: tuple[int, int]) -> tuple[Array, int]:
    """Squares around some search regions, so large that a ball on the circle is whole in them.

    Returns the upper left corners, (M, 2) int px, and the side, px, the same for all: that of the
    largest, but no window exceeds twice the picture, of width and height `size`.
    """
    reach = circles.radius[chosen] + WINDOW * circles.ball[chosen]
    half = int(min(reach.max(initial=0), max(size))) + 3
    return np.rint(circles.center[chosen]).astype(int) - half, 2 * half + 1


def search_spheres(forecast: Forecast, minimum: float, scale: float) -> Array:
    """T_3D: radius `scale` times the last displacement, at least `minimum` (section 3.5).

    minimum: m. Returns (T,) m.
    """
    displacement = np.linalg.norm(forecast.last - forecast.before, axis=1)
    return np.asarray(np.maximum(scale * displacement, minimum))
