"""Where a target is looked for: circles in the views (Jin & Qian 2008, eq. 3) and spheres in the room."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, TRACKED, Forecast

WINDOW = 1.5
"""Balls' radii by which a window exceeds its search circle."""
FARTHEST_OFF = 0.1
"""Cosine of the angle from the optical axis up to which outlines become longer."""
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


class Images(NamedTuple):
    """Forecasts as the C views of a room show them; NaN behind a camera and for lost targets."""

    center: Array
    """(C, T, 2) px."""
    travel: Array
    """(C, T) px, expected from frame to frame."""
    ball: Array
    """(C, T) px, radius of the outline."""


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
    room: Room, camera: str, forecast: Forecast | None, minimum: float, scale: float
) -> Circles:
    """Circles around the forecasts reprojected into one view (section 3.3), and the balls in them.

    minimum: px; scale: of the expected travel.
    """
    count = len(room.targets)
    lost = lost_targets(forecast, count)
    if forecast is None or lost.all():
        nowhere = np.full((count, 2), np.nan)
        return Circles(nowhere, np.full(count, minimum), nowhere[:, 0], lost)
    images, number = forecast_images(room, forecast), list(room.cameras).index(camera)
    radius = search_radius(images.travel[number], minimum, scale)
    return Circles(images.center[number], radius, images.ball[number], lost)


@lru_cache(maxsize=8)
def forecast_images(room: Room, forecast: Forecast) -> Images:
    """Forecasts reprojected into all views at once, for whichever stage of a worker asks first."""
    views, count = room_views(room), len(room.targets)
    sizes = np.array([t.radius for t in room.targets.values()])
    base = views.local(np.concatenate([forecast.xyz, forecast.last, forecast.before]))
    local = np.concatenate([base, base[:, :count], base[:, :count]], axis=1)
    local[:, 3 * count : 4 * count, 0] += sizes
    local[:, 4 * count :, 1] += sizes
    pixel = views.project_local(local).reshape(len(base), 5, count, 2)
    offset = pixel[:, [2, 3, 4]] - pixel[:, [1, 0, 0]]
    travel, right, down = np.hypot(offset[..., 0], offset[..., 1]).swapaxes(0, 1)
    center, ball = pixel[:, 0], (right + down) / 2 * elongation(base[:, :count])
    lost = forecast.state == LOST
    if lost.any():
        center[:, lost], ball[:, lost] = np.nan, np.nan
    return Images(center, travel, ball)


@lru_cache(maxsize=8)
def room_views(room: Room) -> Views:
    """The cameras of a room."""
    return Views(room.cameras.values())


def elongation(local: Array) -> Array:
    """Mean semi-axis of a sphere's outline over that across the axis, (...,).

    A sphere seen at an angle a from the optical axis looks 1 / cos a longer towards it than across.
    local: (..., 3) m, in camera coordinates.
    """
    distance = np.sqrt(np.einsum("...i,...i->...", local, local))
    return np.asarray(0.5 + 0.5 * distance / np.maximum(local[..., 2], FARTHEST_OFF * distance + TINY))


def distances(points: Array, centers: Array) -> Array:
    """Between all of both: (N, 2) and (T, 2) px -> (N, T)."""
    x, y = points[:, :1] - centers[:, 0], points[:, 1:] - centers[:, 1]
    return np.asarray(np.sqrt(x * x + y * y))


def within(circles: Circles, pixel: Array) -> Array:
    """Which points lie in which target's search region: (N, 2) px -> (N, T) bool; in a lost one's all do."""
    inside = distances(pixel, circles.center) <= circles.radius
    inside |= circles.lost
    return inside


def reaching(circles: Circles, size: tuple[int, int]) -> Array:
    """Targets whose search region reaches into a picture of this width and height, px: their numbers."""
    half = np.array(size) / 2
    inside = np.abs(circles.center - half) <= half + circles.radius[:, None]
    return np.flatnonzero(inside[:, 0] & inside[:, 1])


def windows(circles: Circles, chosen: Array, size: tuple[int, int]) -> tuple[Array, int]:
    """Squares around some search regions, so large that a ball on the circle is whole in them.

    Returns the upper left corners, (M, 2) int px, and the side, px, the same for all: that of the
    largest, but no window exceeds twice the picture, of width and height `size`.
    """
    reach = (circles.radius + WINDOW * circles.ball).take(chosen)
    half = int(min(reach.max(initial=0), max(size))) + 3
    return np.rint(circles.center.take(chosen, axis=0)).astype(int) - half, 2 * half + 1


def search_spheres(forecast: Forecast, minimum: float, scale: float) -> Array:
    """T_3D: radius `scale` times the last displacement, at least `minimum` (section 3.5).

    minimum: m. Returns (T,) m.
    """
    displacement = np.linalg.norm(forecast.last - forecast.before, axis=1)
    return np.asarray(np.maximum(scale * displacement, minimum))
