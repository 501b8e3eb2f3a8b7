"""Search regions of targets in the room: spheres around their forecasts (Jin & Qian 2008, section 3.5)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot import Field, StageParams
from followspot.messages import Array
from followspot.tracking import TRACKED, Forecast
from followspot_balls.scene.distances import squared_distances
from followspot_balls.scene.targets import lost_targets


class SphereParams(StageParams):
    """How far from the forecast a target is searched for in the room."""

    minimum_search_radius: float = Field(
        0.225,
        gt=0,
        unit="m",
        description="smallest search radius around the forecast; raising it survives jumps",
    )
    search_radius_scale: float = Field(
        2.0,
        gt=0,
        unit="1",
        description="search radius over the last displacement (beta); raising it survives turns",
    )


def search_spheres(forecast: Forecast, minimum: float, scale: float) -> Array:
    """T_3D: radius `scale` times the last displacement, at least `minimum` (section 3.5).

    minimum: m. Returns (T,) m.
    """
    displacement = np.sqrt(np.square(forecast.last - forecast.before).sum(axis=1))
    return np.asarray(np.maximum(scale * displacement, minimum))


def in_search_spheres(
    xyz: Array,
    labelled: Array,
    forecast: Forecast | None,
    radii: Array,
    reach: Callable[[Forecast], Array],
    alike: Array | None = None,
) -> Array:
    """Which points lie in which target's search sphere: (N, T) bool; a lost target's is the room.

    An unlabelled point may serve several targets, but not if it lies inside a ball that is tracked
    and outside one's own, for balls do not share their place; nor may one labelled with the colour
    of both.
    xyz: (N, 3) m, NaN for none; labelled: (N,) bool; radii: (T,) m, of the targets; reach: the radii of the
    spheres, (T,) m; alike: (T, T) bool, which targets have one colour, None if none have.
    """
    lost = lost_targets(forecast, len(radii))[:, None]
    real = ~np.isnan(xyz[:, 0])
    if forecast is None or np.count_nonzero(lost) == lost.size:
        return np.asarray(real & lost).T
    spheres = reach(forecast)[:, None]
    distance2 = squared_distances(forecast.xyz, xyz)
    ball = (distance2 <= np.square(radii)[:, None]) & ~lost
    tracked = ball & (forecast.state == TRACKED)[:, None]
    taken = ~labelled & tracked.any(axis=0)
    if alike is not None:
        taken = taken | (alike.T @ tracked)
    return np.asarray(real & (lost | (distance2 <= spheres * spheres)) & (ball | ~taken)).T
