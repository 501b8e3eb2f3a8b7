"""Where a target is looked for: circles in the views (Jin & Qian 2008, eq. 3) and spheres in the room."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera
from followspot.tracking import LOST, TRACKED, Forecast


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

    travel: (...,) px between the last two estimates; minimum: px. Returns (...,) px.
    """
    return np.asarray(np.where(travel <= minimum, minimum, scale * travel))


def search_circles(
    camera: Camera, forecast: Forecast | None, sizes: Array, minimum: float, scale: float
) -> Circles:
    """Circles around the forecasts reprojected into one view (section 3.3).

    sizes: (T,) radii of the targets, m; minimum: px.
    """
    count = len(sizes)
    lost = lost_targets(forecast, count)
    if forecast is None or lost.all():
        nowhere = np.full((count, 2), np.nan)
        return Circles(nowhere, np.full(count, minimum), nowhere[:, 0], lost)
    xyz = forecast.xyz
    points = np.concatenate([xyz, forecast.last, forecast.before, rim(camera, xyz, sizes)])
    center, last, before, *sides = project(camera, points).reshape(5, count, 2)
    center[lost] = np.nan
    ball = np.hypot(*(sides - center).transpose(2, 0, 1)).mean(axis=0)
    travel = np.nan_to_num(np.hypot(*(last - before).T))
    return Circles(center, search_radius(travel, minimum, scale), ball, lost)


def rim(camera: Camera, xyz: Array, sizes: Array) -> Array:
    """Two points of each sphere's outline, across the viewing direction: (2 T, 3) m."""
    direction = xyz - camera.center
    level = np.cross(direction, camera.rotation[1])
    steep = np.cross(direction, level)
    across = np.stack([level, steep])
    length = np.linalg.norm(across, axis=2, keepdims=True)
    outline = xyz + across * (sizes[:, None] / np.maximum(length, np.finfo(float).tiny))
    return np.asarray(outline.reshape(-1, 3))


def search_spheres(forecast: Forecast, minimum: float, scale: float) -> Array:
    """T_3D: radius `scale` times the last displacement, at least `minimum` (section 3.5).

    minimum: m. Returns (T,) m.
    """
    displacement = np.linalg.norm(forecast.last - forecast.before, axis=1)
    return np.asarray(np.maximum(scale * displacement, minimum))
