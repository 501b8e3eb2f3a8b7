"""Readings at even times: those that are missing between others, and the field of a slower magnetometer."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.rotation import from_rotation_vector, inverse, turned

UNKNOWN = np.full(3, np.nan)


def evenly(time: Array, values: Array, period: float) -> tuple[Array, Array]:
    """The readings, with those that are missing between them interpolated, and the row of each reading.

    time: (N,) ns; values: (N, K). Returns (M, K), M >= N, and (N,).
    """
    steps = np.maximum(np.rint(np.diff(time) * (NANOSECOND / period)), 1).astype(np.int64)
    index = np.concatenate([[0], np.cumsum(steps)])
    if index[-1] == len(time) - 1:
        return values, index
    row = np.arange(index[-1] + 1)
    return np.stack([np.interp(row, index, column) for column in values.T], axis=1), index


def carried(last: Array, field: Array, turn: Array) -> Array:
    """The field at each reading; where it was not read, that of before, against which the sensor has turned.

    last: (3,) before the first reading; field: (N, 3), NaN where it was not read; turn: (N, 3) rotation
    vectors of the sensor in its axes up to each reading, rad. Returns (N, 3).
    """
    known: Array = np.asarray(np.isfinite(field).all(axis=1))
    if known.all():
        return field
    back, found = inverse(from_rotation_vector(turn)), np.empty_like(field)
    for row in range(len(field)):
        last = field[row] if known[row] else turned(back[row], last)
        found[row] = last
    return found
