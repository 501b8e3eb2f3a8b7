"""What a forecast and the room say of the targets, an entry for each: lost, tracked, and how large."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, PREDICTED, TRACKED, Forecast


@lru_cache(maxsize=16)  # the stages of a worker ask the same of each forecast
def lost_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets have no forecast: all, before the first one. Returns (T,) bool, read-only."""
    if forecast is None or len(forecast.state) != count:
        return unchanging(np.ones(count, bool))
    return unchanging(forecast.state == LOST)


@lru_cache(maxsize=16)
def tracked_targets(forecast: Forecast | None, count: int) -> Array:
    """Which of `count` targets had a position in the previous frame; initially none. (T,) bool, read-only."""
    if forecast is None or len(forecast.state) != count:
        return unchanging(np.zeros(count, bool))
    return unchanging((forecast.state == TRACKED) | (forecast.state == PREDICTED))


def unchanging(array: Array) -> Array:
    """Make an array read-only and return it: no stage that shares it can change it."""
    array.setflags(write=False)
    return array


@lru_cache(maxsize=8)
def target_radii(room: Room) -> Array:
    """Radius of each target, (T,) m."""
    return np.array([target.radius for target in room.targets.values()])
