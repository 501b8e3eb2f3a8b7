"""Matching by time, and statistics that are NaN for no values."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot.messages import Array

SAME = 1e-4
"""Difference of times that comes of rounding, s; frames are farther apart."""


def frames_of(times: Array, same: float = SAME) -> tuple[Array, Array]:
    """Times of frames, (F,) s, ascending, and the frame of each of these times (N,): equal ones but for their
    rounding, of at most `same` s, are of one frame.
    """
    ascending, place = np.unique(times, return_inverse=True)
    begins = np.diff(ascending, prepend=-np.inf) > same
    return ascending[begins], (np.cumsum(begins) - 1)[place]


def nearest(grid: Array, values: Array) -> tuple[Array, Array]:
    """Index of the nearest element of an ascending grid for each value, and the distance to it."""
    after = np.clip(np.searchsorted(grid, values), 0, len(grid) - 1)
    before = np.maximum(after - 1, 0)
    index = np.where(np.abs(grid[before] - values) <= np.abs(grid[after] - values), before, after)
    return index, np.abs(grid[index] - values)


def half_interval(time: Array) -> float:
    """Half the usual distance of neighbouring times, s; everything is near a single one."""
    return float(np.median(np.diff(time))) / 2 if len(time) > 1 else np.inf


def share(part: Array, whole: Array) -> float:
    """How much of one set of frames is in another; NaN for an empty one."""
    return float(part.sum() / whole.sum()) if whole.any() else np.nan


def statistic(values: Array, of: Callable[[Array], float]) -> float:
    """A statistic, NaN if there are no values."""
    return float(of(values)) if len(values) else np.nan


def root_mean_square(values: Array) -> float:
    """Square root of the mean of squares."""
    return float(np.sqrt(np.mean(np.square(values))))
