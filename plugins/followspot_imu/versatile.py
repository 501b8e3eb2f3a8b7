"""VQF (Laidig & Seel, Information Fusion 91, 2023) through the package `vqf`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot import Array
from followspot.errors import InputError, Mistake


class Versatile:
    """The filter of the package, reading by reading: it learns the gyroscope's bias at rest and in motion.

    period: of the readings, s; time_constant: over which the accelerometer corrects, s. Raises InputError if
    the package is not installed.
    """

    def __init__(self, period: float, time_constant: float) -> None:
        try:
            from vqf import VQF
        except ImportError:
            raise InputError(
                [
                    Mistake(
                        None,
                        "imu.orientation with method vqf needs the package vqf, which is not installed",
                        "pip install 'followspot[imu]', or method: complementary",
                    )
                ]
            ) from None
        self.filter = VQF(period, tauAcc=time_constant)

    def update(self, turn_rate: Array, specific_force: Array, field: Array | None) -> Array:
        readings = [np.ascontiguousarray(each) for each in (turn_rate, specific_force)]
        if field is None:
            return np.asarray(self.filter.updateBatch(*readings)["quat6D"])
        return np.asarray(self.filter.updateBatch(*readings, np.ascontiguousarray(field))["quat9D"])

    def state(self) -> Mapping[str, Any]:
        return {
            name: value.item() if isinstance(value, np.generic) else value
            for name, value in self.filter.state.items()
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        self.filter.state = {
            name: np.array(value) if isinstance(value, np.ndarray | list) else value
            for name, value in state.items()
        }
