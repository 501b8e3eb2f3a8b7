"""True readings of an inertial sensor on a ball that moves and turns, without errors of the sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.rotation import inverse, multiply, rotation_vector, turned
from followspot_sim.imu.path import Path
from followspot_sim.imu.turning import Turning
from followspot_sim.world import GRAVITY


@dataclass(frozen=True, eq=False)
class Mount:
    """A sensor on a ball. lever_arm: (3,) m, in axes of the ball, which are the sensor's."""

    path: Path
    turning: Turning
    ball: int
    rate: float
    clock_offset: float
    lever_arm: Array
    contact_time: float

    def orientation(self, first: int, count: int, shift: float = 0.0) -> Array:
        """From axes of the sensor to those of the room; shift: of the times, in intervals. (count, 4)."""
        number = np.arange(first, first + count) + shift
        return self.turning.at(self.ball, number / self.rate + self.clock_offset)

    def turn_rate(self, first: int, count: int) -> Array:
        """Mean over the interval about each reading, (count, 3) rad/s: the turn from its begin to its end."""
        q = self.orientation(first, count + 1, -0.5)
        return self.rate * rotation_vector(multiply(inverse(q[:-1]), q[1:]))

    def specific_force(self, first: int, count: int) -> Array:
        """Mean over the interval about each reading, (count, 3) m/s^2, in axes of the sensor."""
        lever = turned(self.orientation(first - 1, count + 2), self.lever_arm)
        swing = self.rate**2 * np.diff(lever, 2, axis=0)
        force = self.acceleration(first, count) + swing - GRAVITY
        return turned(inverse(self.orientation(first, count)), force)

    def acceleration(self, first: int, count: int) -> Array:
        """Of the ball's centre, whose path is averaged over the contact time, (count, 3) m/s^2.

        The path has corners where a ball is thrown and caught; no sensor could read what it feels there.
        """
        half = max(1, round(self.contact_time * self.rate / 2))
        centres = self.path.centres(first - half, count + 1 + 2 * half)[:, self.ball]
        velocity = (centres[2 * half :] - centres[: -2 * half]) * self.rate / (2 * half)
        return self.rate * np.diff(velocity, axis=0)
