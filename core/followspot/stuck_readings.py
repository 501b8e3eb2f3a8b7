"""Readings of an inertial sensor that has hung, or whose program sends the last one again and again."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array

STUCK = 50_000_000
"""Time after which a sensor in motion that repeats its reading is not believed, ns."""
TURNING, PUSHED = 0.2, 1.0
"""Turn rate, rad/s, and deviation of the force from gravity, m/s^2, of a sensor that is surely in motion."""
GRAVITY = 9.81
"""m/s^2."""
REMEDY = "look whether it has hung, or its program sends the last one again"


def runs(values: Array) -> Array:
    """Row of the first of the equal readings in a row to which each belongs, (N,). values: (N, K)."""
    same = np.append(False, (values[1:] == values[:-1]).all(axis=1))[: len(values)]
    return np.asarray(np.maximum.accumulate(np.where(same, 0, np.arange(len(values)))))


def stuck(time: Array, values: Array) -> Array:
    """Which readings only repeat one that says that the sensor moves, (N,) bool.

    At rest readings may repeat, if their digits are few. time: (N,) rising, ns; values: (N, 6) turn rate,
    rad/s, and specific force, m/s^2.
    """
    first = runs(values)
    repeated = time - time[first] > STUCK
    if not repeated.any():
        return repeated
    pushed = np.abs(np.linalg.norm(values[:, 3:], axis=1) - GRAVITY) > PUSHED
    return np.asarray(repeated & (pushed | (np.linalg.norm(values[:, :3], axis=1) > TURNING)))
