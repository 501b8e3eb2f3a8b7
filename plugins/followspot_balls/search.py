"""Where a target is looked for: circles in the views (Jin & Qian 2008, eq. 3) and spheres in the room."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera
from followspot.tracking import LOST, Forecast


class Circles(NamedTuple):
    """Search regions of one view, a row for each target."""

    center: Array
    """(T, 2) px, as in the picture; NaN behind the camera and for lost targets."""
    radius: Array
    """(T,) px."""
    lost: Array
    """(T,) bool: looked for in the whole image."""


def lost_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets have no forecast: all, before the first one. Returns (T,) bool."""
    if forecast is None or len(forecast.state) != count:
        return np.ones(count, bool)
    return np.asarray(forecast.state == LOST)


def search_radius(travel: Array, minimum: float, scale: float) -> Array:
    """T_2D: `minimum` while the expected travel is at most that, else `scale` times the travel (eq. 3).

    travel: (...,) px between the last two estimates; minimum: px. Returns (...,) px.
    """
    return np.asarray(np.where(travel <= minimum, minimum, scale * travel))


def search_circles(
    camera: Camera, forecast: Forecast | None, count: int, minimum: float, scale: float
) -> Circles:
    """Circles around the forecasts reprojected into one view (section 3.3)."""
    lost = lost_targets(forecast, count)
    if forecast is None or len(forecast.state) != count:
        return Circles(np.full((count, 2), np.nan), np.full(count, minimum), lost)
    pixel = project(camera, np.concatenate([forecast.xyz, forecast.last, forecast.before]))
    center, last, before = pixel.reshape(3, count, 2)
    center[lost] = np.nan
    travel = np.hypot(*(last - before).T)
    return Circles(center, search_radius(np.nan_to_num(travel), minimum, scale), lost)


def search_spheres(forecast: Forecast, minimum: float, scale: float) -> Array:
    """T_3D: radius `scale` times the last displacement, at least `minimum` (section 3.5).

    minimum: m. Returns (T,) m.
    """
    displacement = np.linalg.norm(forecast.last - forecast.before, axis=1)
    return np.maximum(scale * displacement, minimum)
