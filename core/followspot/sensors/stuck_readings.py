"""Stuck readings: an inertial sensor hangs, or its program sends the last reading again and again."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array

STUCK = 50_000_000
"""Time for which a sensor in motion may repeat its reading, ns."""
TURNING, PUSHED = 0.2, 1.0
"""Turn rate, rad/s, and deviation of the force from gravity, m/s^2, of a sensor that is surely in motion."""
GRAVITY = 9.81
"""m/s^2."""
REMEDY = "look whether it has hung, or its program sends the last one again"


def runs(values: Array) -> Array:
    """For each reading, the row of the first reading of its run of equal readings, (N,). values: (N, K)."""
    same = np.append(False, (values[1:] == values[:-1]).all(axis=1))[: len(values)]
    return np.asarray(np.maximum.accumulate(np.where(same, 0, np.arange(len(values)))))


def stuck(time: Array, values: Array) -> Array:
    """Which readings repeat an earlier one for too long although it shows motion, (N,) bool.

    The readings of a sensor at rest may repeat if they have few digits. time: (N,) rising, ns; values: (N, 6)
    turn rate, rad/s, and specific force, m/s^2.
    """
    first = runs(values)
    repeated = time - time[first] > STUCK
    if not repeated.any():
        return repeated
    pushed = np.abs(np.linalg.norm(values[:, 3:], axis=1) - GRAVITY) > PUSHED
    return np.asarray(repeated & (pushed | (np.linalg.norm(values[:, :3], axis=1) > TURNING)))
