"""Filters of orientation: from turn rates and specific forces, in axes with z upward and any heading."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from followspot import Array
from followspot.rotation import from_rotation_vector, multiply, turned

GRAVITY = 9.81
"""m/s^2."""
STILL = 0.5
"""Deviation of the specific force from gravity at which it is believed half, m/s^2."""


class AttitudeFilter(Protocol):
    """Orientation at each of the readings of a sensor that come at a constant rate."""

    def update(self, turn_rate: Array, specific_force: Array, field: Array | None) -> Array:
        """Orientations (N, 4) after N readings, (N, 3) rad/s, m/s^2 and uT; field: None if unused."""

    def state(self) -> Mapping[str, Any]:
        """Checkpoint of plain values."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Carry on from a checkpoint."""


class Complementary:
    """The gyroscope tells fast changes, the accelerometer slow ones of the inclination (Mahony et al. 2008).

    period: of the readings, s; time_constant: over which the accelerometer corrects, s. The more the force
    differs from gravity, the less it corrects. It learns no bias of the gyroscope, and uses no magnetometer.
    """

    def __init__(self, period: float, time_constant: float) -> None:
        self.period = period
        self.gain = min(1.0, period / time_constant)
        self.q = np.zeros(4)

    def update(self, turn_rate: Array, specific_force: Array, field: Array | None) -> Array:
        found = np.empty((len(turn_rate), 4))
        for row, (step, force) in enumerate(zip(turn_rate * self.period, specific_force, strict=True)):
            if not self.q.any():
                self.q = _leaning(force, np.array([1.0, 0.0, 0.0, 0.0]), 1.0)
            self.q = multiply(self.q, from_rotation_vector(step))
            away = (np.linalg.norm(force) - GRAVITY) / STILL
            self.q = _leaning(force, self.q, float(self.gain / (1.0 + away * away)))
            self.q /= np.linalg.norm(self.q)
            found[row] = self.q
        return found

    def state(self) -> Mapping[str, Any]:
        return {"q": self.q}

    def restore(self, state: Mapping[str, Any]) -> None:
        self.q = np.array(state["q"])


def _leaning(force: Array, q: Array, share: float) -> Array:
    """The orientation turned so that a force points upward, by a share of the angle. force: (3,); q: (4,)."""
    up = turned(q, force)
    length = np.linalg.norm(up)
    if length == 0:
        return q
    axis = np.array([up[1], -up[0], 0.0])
    sine = np.linalg.norm(axis)
    angle = share * np.arctan2(sine, up[2])
    axis = axis / sine if sine > 1e-9 * length else np.array([1.0, 0.0, 0.0])
    return multiply(from_rotation_vector(axis * angle), q)
