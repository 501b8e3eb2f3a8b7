"""Readings that arrive one by one, collected into messages."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.frame_times import to_ns
from followspot.sensors.reading_batches import BatchParams
from followspot_imu.units import VALUES


class Collection:
    """The readings of one message."""

    def __init__(self, params: BatchParams) -> None:
        self._most, self._span = params.batch, to_ns(params.batch_time)
        self._times: list[int] = []
        self._values: list[tuple[float, ...]] = []

    def __len__(self) -> int:
        return len(self._times)

    def add(self, time: int, values: tuple[float, ...]) -> None:
        """Add a reading. time: ns; values: 9, in the order of `VALUES`."""
        self._times.append(time)
        self._values.append(values)

    def complete(self, now: int) -> bool:
        """Whether the message should go out at a time, ns."""
        times = self._times
        return len(times) >= self._most or (bool(times) and now - times[0] >= self._span)

    def taken(self) -> tuple[Array, Array]:
        """Times (N,) ns and values (N, 9) of the message, which is empty from now on."""
        times, values = np.array(self._times, "i8"), np.array(self._values, "f8").reshape(-1, len(VALUES))
        self._times, self._values = [], []
        return times, values
