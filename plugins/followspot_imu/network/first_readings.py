"""The first readings of a sensor in the network, by which its units are doubted."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_imu.units import doubts_of_units

ENOUGH = 100
"""Readings that tell whether the units are right."""


class FirstReadings:
    """Collects readings until there are `ENOUGH`."""

    def __init__(self) -> None:
        self._turn_rate, self._force = [np.zeros((0, 3))], [np.zeros((0, 3))]
        self._missing = ENOUGH

    def doubts(self, turn_rate: Array, force: Array) -> dict[str, str]:
        """Why the units are hardly right, by parameter, once there are enough; else none.

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
