"""Readings and orientations of one sensor over the last second, in the order of their capture times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot.inertial import Inertial, Orientation
from followspot.messages import MAX_TIME
from followspot.sensors.stuck_readings import stuck

MAXIMUM_ROWS = 8192
"""Largest number of rows that are kept, at any rate."""
MAXIMUM_TURN_RATE = 100.0
"""Largest plausible turn rate, rad/s."""
MAXIMUM_FORCE = 4000.0
"""Largest plausible specific force, m/s^2."""


class Rows(NamedTuple):
    """Values by capture time: time (N,) ns, rising; values (N, K)."""

    time: Array
    values: Array

    @classmethod
    def none(cls, width: int) -> Rows:
        """No rows."""
        return cls(np.zeros(0, np.int64), np.zeros((0, width)))

    def since(self, time: int) -> Rows:
        """The rows after a capture time, ns, the newest `MAXIMUM_ROWS` of them."""
        first = max(int(self.time.searchsorted(time, side="right")), len(self.time) - MAXIMUM_ROWS)
        return Rows(self.time[first:], self.values[first:])

    def between(self, after: int, until: int) -> Rows:
        """The rows later than one capture time, up to another, ns."""
        first, last = self.time.searchsorted([after, until], side="right")
        return Rows(self.time[first:last], self.values[first:last])

    def with_rows(self, other: Rows) -> Rows:
        """Both together; of equal times the earlier arrival stays."""
        if not len(other.time):
            return self
        time = np.concatenate([self.time, other.time])
        values = np.concatenate([self.values, other.values])
        if (time[1:] > time[:-1]).all():
            return Rows(time, values)
        time, first = np.unique(time, return_index=True)
        return Rows(time, values[first])


def readings_of(messages: Sequence[Inertial], sensor: str) -> Rows:
    """Turn rates and specific forces of one sensor, (N, 6); implausible ones are left out."""
    rows = Rows.none(6)
    for message in messages:
        if message.sensor == sensor:
            values = np.concatenate([message.turn_rate, message.specific_force], axis=1)
            kept = _plausible(message)
            rows = rows.with_rows(Rows(message.time[kept], values[kept]))
    return rows


def implausible_count(messages: Sequence[Inertial], sensor: str) -> int:
    """Number of readings of one sensor that are implausible."""
    return sum(int(np.count_nonzero(~_plausible(m))) for m in messages if m.sensor == sensor)


def _plausible(message: Inertial) -> Array:
    """Which readings, (N,), are plausible; NaN is beyond every limit."""
    turn_rate = (np.abs(message.turn_rate) <= MAXIMUM_TURN_RATE).all(axis=1)
    force = (np.abs(message.specific_force) <= MAXIMUM_FORCE).all(axis=1)
    return np.asarray(_in_time(message.time) & turn_rate & force)


def orientations_of(messages: Sequence[Orientation], sensor: str) -> Rows:
    """Quaternions and sigmas of the inclination of one sensor, (N, 5), where they are known."""
    rows = Rows.none(5)
    for message in messages:
        if message.sensor == sensor:
            values = np.concatenate([message.quaternion, message.inclination_sigma[:, None]], axis=1)
            length = np.linalg.norm(message.quaternion, axis=1)
            kept = _in_time(message.time) & (np.abs(length - 1) < 1e-3) & (values[:, 4] >= 0)
            rows = rows.with_rows(Rows(message.time[kept], values[kept]))
    return rows


def changing(readings: Rows) -> Rows:
    """The readings, (N, 6), without those of a sensor that is stuck."""
    repeated = stuck(*readings)
    return Rows(readings.time[~repeated], readings.values[~repeated]) if repeated.any() else readings


def _in_time(time: Array) -> Array:
    return np.asarray(np.abs(time) <= MAX_TIME)


def with_orientations(readings: Rows, orientations: Rows) -> Rows:
    """Readings with their orientations, (N, 11), at the times of both."""
    time, row, other = np.intersect1d(
        readings.time, orientations.time, assume_unique=True, return_indices=True
    )
    return Rows(time, np.concatenate([readings.values[row], orientations.values[other]], axis=1))
