"""The time of a camera's own clock in that of this host, from timed readings of the camera's clock."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

KEPT = 96
"""Number of newest readings that are used."""
FLOOR = 10_000.0
"""Standard deviation of the best reading, ns."""
CRYSTAL = 50e-6
"""Standard deviation of the rate of a camera's clock before it was measured: the tolerance of crystals."""
WILD = 2_000_000
"""A reading that differs by more from what the earlier ones foretell, beside half its round trip, ns, shows
that one of the clocks was set."""


class Reading(NamedTuple):
    """A reading of the camera's clock, ns, and this host's steady clock before and after it, ns."""

    camera: int
    before: int
    after: int

    @property
    def round_trip(self) -> int:
        """Duration of the reading, ns; the camera's clock was read within it."""
        return self.after - self.before

    @property
    def middle(self) -> int:
        """Time of this host halfway, ns."""
        return (self.before + self.after) // 2


class CameraClock:
    """Offset and rate of a camera's clock: a line through the readings with short round trips.

    The middle of a reading differs from the moment at which the camera read its clock by at most half the
    round trip (Mills, RFC 5905, section 8).
    """

    def __init__(self) -> None:
        self._kept: deque[Reading] = deque(maxlen=KEPT)
        self._origin = (0, 0)
        """Of the line: camera time and time of this host, ns."""
        self._rate = 1.0
        """Seconds of this host in one of the camera."""
        self.settings = 0
        """How often one of the clocks was set."""

    @property
    def known(self) -> bool:
        """Whether the clock was read."""
        return bool(self._kept)

    @property
    def round_trip(self) -> int:
        """The shortest of the readings, ns: the error is at most half of it."""
        return min(reading.round_trip for reading in self._kept)

    @property
    def drift(self) -> float:
        """Rate of the camera's clock less that of this host, over it (1e-6: a microsecond a second)."""
        return 1.0 / self._rate - 1.0

    def add(self, reading: Reading) -> None:
        """Take a reading; if it contradicts the others, a clock was set, and they are dropped."""
        if self._kept:
            wrong = abs(reading.middle - self.steady_time(reading.camera))
            if wrong > WILD + (reading.round_trip + self.round_trip) // 2:
                self._kept.clear()
                self._rate = 1.0
                self.settings += 1
        self._kept.append(reading)
        self._fit()

    def steady_time(self, camera: int) -> int:
        """Time of this host's steady clock at a time of the camera, both ns."""
        there, here = self._origin
        passed = camera - there
        return here + passed + round(passed * (self._rate - 1.0))

    def _fit(self) -> None:
        """Fit the line by weighted least squares, with a prior on the rate.

        What a round trip has beyond the shortest one was spent before or after the clock was read: its share
        of the error is uniform within half of it.
        """
        newest = self._kept[-1]
        camera = np.array([reading.camera - newest.camera for reading in self._kept], "f8")
        offset = np.array([reading.middle - newest.middle for reading in self._kept], "f8") - camera
        excess = np.array([reading.round_trip for reading in self._kept], "f8") - self.round_trip
        weight = 1.0 / (FLOOR**2 + excess**2 / 12.0)
        centre = float(weight @ camera / weight.sum())
        away = camera - centre
        rate = float(weight @ (away * offset)) / (float(weight @ away**2) + CRYSTAL**-2)
        shift = float(weight @ offset / weight.sum()) - centre * rate
        self._rate = 1.0 + rate
        self._origin = newest.camera, newest.middle + round(shift)
