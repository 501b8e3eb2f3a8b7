"""What a forecast and the room say of the targets, an entry for each: lost, tracked, and how large."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, PREDICTED, TRACKED, Forecast


def lost_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets have no forecast: all, before the first one. Returns (T,) bool."""
    if forecast is None or len(forecast.state) != count:
        return np.ones(count, bool)
    return np.asarray(forecast.state == LOST)


def tracked_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets had a position in the previous frame; initially none. Returns (T,) bool."""
    if forecast is None or len(forecast.state) != count:
        return np.zeros(count, bool)
    return np.asarray((forecast.state == TRACKED) | (forecast.state == PREDICTED))


@lru_cache(maxsize=8)
def target_radii(room: Room) -> Array:
    """Radius of each target, (T,) m."""
    return np.array([target.radius for target in room.targets.values()])
