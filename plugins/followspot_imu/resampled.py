"""Readings at even times: those that are missing between others, and the field of a slower magnetometer."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.rotation import from_rotation_vector, inverse, turned

UNKNOWN = np.full(3, np.nan)
"""A field, (3,) uT, before the magnetometer has given one."""


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
    """The field at each reading, in the sensor's axes: as it was read, or else that of the reading before,
    turned back by the sensor's rotation since then.

    last: (3,) uT, at the reading before the first; field: (N, 3) uT, NaN if it was not read; turn: (N, 3)
    rotation vectors from each reading's predecessor to the reading, rad. Returns (N, 3) uT.
    """
    known: Array = np.asarray(np.isfinite(field).all(axis=1))
    if known.all():
        return field
    back, found = inverse(from_rotation_vector(turn)), np.empty_like(field)
    for row in range(len(field)):
        last = field[row] if known[row] else turned(back[row], last)
        found[row] = last
    return found
