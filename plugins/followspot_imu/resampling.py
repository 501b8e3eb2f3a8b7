"""Resampling of readings to even times, and of the field of a magnetometer that reads less often."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.rotation import from_rotation_vector, inverse, turned

UNKNOWN = np.full(3, np.nan)
"""A field, (3,) uT, before the magnetometer has given one."""


def at_even_times(time: Array, values: Array, period: float) -> tuple[Array, Array]:
    """The readings, with those that are missing between them interpolated, and the row of each reading.

    time: (N,) ns; values: (N, K). Returns (M, K), M >= N, and (N,).
    """
    steps = np.maximum(np.rint(np.diff(time) * (NANOSECOND / period)), 1).astype(np.int64)
    index = np.concatenate([[0], np.cumsum(steps)])
    if index[-1] == len(time) - 1:
        return values, index
    row = np.arange(index[-1] + 1)
    return np.stack([np.interp(row, index, column) for column in values.T], axis=1), index


def propagated_field(last: Array, field: Array, rotation: Array) -> Array:
    """The magnetic field at each reading, in the sensor's axes.

    It is the measured one or, if it was not measured, that at the previous reading rotated back by the
    rotation of the sensor since then.

    last: (3,) uT, at the reading before the first; field: (N, 3) uT, NaN if it was not measured; rotation:
    (N, 3) rotation vectors from each reading's predecessor to the reading, rad. Returns (N, 3) uT.
    """
    measured = np.append(True, np.isfinite(field).all(axis=1))
    if measured.all():
        return field
    found, row = np.concatenate([last[None], field]), np.arange(len(measured))
    age = row - np.maximum.accumulate(np.where(measured, row, 0))
    back = inverse(from_rotation_vector(rotation))
    for step in range(1, int(age.max()) + 1):
        rows = np.flatnonzero(age == step)
        found[rows] = turned(back[rows - 1], found[rows - 1])
    return found[1:]
