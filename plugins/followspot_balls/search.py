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
    camera: Camera, forecast: Forecast | None, count: int, minimum: float, scale: float
) -> Circles:
    """Circles around the forecasts of `count` targets reprojected into one view (section 3.3).

    minimum: px.
    """
    lost = lost_targets(forecast, count)
    if forecast is None or lost.all():
        return Circles(np.full((count, 2), np.nan), np.full(count, minimum), lost)
    pixel = project(camera, np.concatenate([forecast.xyz, forecast.last, forecast.before]))
    center, last, before = pixel.reshape(3, count, 2)
    center[lost] = np.nan
    travel = last - before
    return Circles(center, search_radius(np.hypot(travel[:, 0], travel[:, 1]), minimum, scale), lost)


def outline_radius(camera: Camera, center: Array, xyz: Array, sizes: Array) -> Array:
    """Radius of spheres in the picture, (T,) px: the mean of the two semi-axes of their outline.

    A sphere seen at an angle a from the optical axis is 1 / cos a longer away from the axis than across.
    center: (T, 2) px, their images, NaN without one; xyz: (T, 3) m; sizes: (T,) radii, m.
    """
    shift = camera.rotation[:2, None] * sizes[:, None]
    sides = project(camera, (xyz + shift).reshape(-1, 3)).reshape(2, -1, 2) - center
    across = np.hypot(sides[..., 0], sides[..., 1]).sum(axis=0) / 2
    direction = xyz - camera.center
    distance = np.sqrt(np.einsum("ij,ij->i", direction, direction))
    cosine = direction @ camera.rotation[2] / np.maximum(distance, np.finfo(float).tiny)
    return np.asarray(across * (1 + 1 / np.maximum(cosine, 0.1)) / 2)


def search_spheres(forecast: Forecast, minimum: float, scale: float) -> Array:
    """T_3D: radius `scale` times the last displacement, at least `minimum` (section 3.5).

    minimum: m. Returns (T,) m.
    """
    displacement = np.linalg.norm(forecast.last - forecast.before, axis=1)
    return np.asarray(np.maximum(scale * displacement, minimum))
