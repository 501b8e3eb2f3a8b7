"""The first readings of a sensor in the network, from which its units are checked."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_imu.units import doubts_of_units

ENOUGH = 100
"""Readings from which the units are checked."""


class FirstReadings:
    """Collects the first `ENOUGH` readings, and checks whether their units are plausible."""

    def __init__(self) -> None:
        self._turn_rate, self._force = [np.zeros((0, 3))], [np.zeros((0, 3))]
        self._missing = ENOUGH

    def doubts(self, turn_rate: Array, force: Array) -> dict[str, str]:
        """Reasons to doubt the units, by parameter, once there are enough readings; else none.

        turn_rate, force: of the next readings, (N, 3) rad/s and m/s^2.
        """
        if self._missing <= 0:
            return {}
        self._turn_rate.append(turn_rate)
        self._force.append(force)
        self._missing -= len(force)
        if self._missing > 0:
            return {}
        found = doubts_of_units(np.concatenate(self._turn_rate), np.concatenate(self._force))
        self._turn_rate, self._force = [], []
        return found
