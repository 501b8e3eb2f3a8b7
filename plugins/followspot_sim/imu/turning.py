"""How the balls of the simulated room turn, as a function of time: slow sines about three axes in turn."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.rotation import canonical, from_rotation_vector, multiply

SLOWEST, FASTEST = 0.1, 0.6
"""Frequencies of the sines, Hz."""
SINES = 2
"""About each axis."""
AXES = np.eye(3)


class Turning:
    """Orientation of every ball; equal seeds give equal ones. The balls turn also while they lie."""

    def __init__(self, seed: int, balls: int, turn_rate: float) -> None:
        """turn_rate: root mean square of the turn rate, rad/s."""
        rng = np.random.default_rng([seed, balls, 0x7E])
        shape = (balls, 3, SINES)
        self._frequency = 2 * np.pi * rng.uniform(SLOWEST, FASTEST, shape)
        self._phase = rng.uniform(-np.pi, np.pi, shape)
        self._amplitude = turn_rate * np.sqrt(2 / (3 * SINES)) / self._frequency

    def at(self, ball: int, time: Array) -> Array:
        """Quaternions from axes of the ball to those of the room. time: (N,) s. Returns (N, 4)."""
        swing = np.sin(self._frequency[ball] * time[:, None, None] + self._phase[ball])
        angle = (self._amplitude[ball] * swing).sum(axis=2)
        about_x, about_y, about_z = (
            from_rotation_vector(a[:, None] * e) for a, e in zip(angle.T, AXES, strict=True)
        )
        return canonical(multiply(about_z, multiply(about_y, about_x)))
