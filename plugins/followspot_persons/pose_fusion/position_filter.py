"""Kalman filter of a person's position on the floor, whose gate rejects positions that nobody can walk to.

Velocities decay and are driven by noise, as in `followspot_persons.associate.motion`: a person walks about
1 m/s. What is too far for that and for the errors of the measurement is outside the gate (Bar-Shalom, Li &
Kirubarajan 2001, section 3.7).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.associate.motion import step

SPEED_SIGMA, MEMORY = 1.0, 1.0
"""Sigma of the velocity of people, m/s, and the time constant of its decay, s."""
GATE = 13.8
"""Squared Mahalanobis distance of two dimensions that one right measurement in a thousand exceeds."""


@dataclass(frozen=True, eq=False)
class PositionTrack:
    """state: (4,) x, y, their velocities, m and m/s; covariance: (4, 4)."""

    state: Array
    covariance: Array

    @classmethod
    def initiated(cls, position: Array, covariance: Array) -> PositionTrack:
        """At one measurement: position (2,) m and its covariance (2, 2) m^2."""
        whole = np.zeros((4, 4))
        whole[:2, :2], whole[2:, 2:] = covariance, SPEED_SIGMA**2 * np.eye(2)
        return cls(np.concatenate([position, np.zeros(2)]), whole)

    @property
    def sigma(self) -> Array:
        """Sigma of x and y, (2,) m."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[:2]))

    def predicted(self, seconds: float) -> PositionTrack:
        """Some time later."""
        fade, reach, xy, cross, velocity = step(seconds, np.array(SPEED_SIGMA), np.array(MEMORY))
        F = np.kron(np.array([[1, reach], [0, fade]]), np.eye(2))
        Q = np.kron(np.array([[xy, cross], [cross, velocity]]), np.eye(2))
        return PositionTrack(F @ self.state, F @ self.covariance @ F.T + Q)

    def updated(self, position: Array, covariance: Array) -> PositionTrack:
        """After a measurement of the same time: position (2,) m and its covariance (2, 2) m^2."""
        gain = self.covariance[:, :2] @ np.linalg.inv(self.covariance[:2, :2] + covariance)
        state = self.state + gain @ (position - self.state[:2])
        return PositionTrack(state, self.covariance - gain @ self.covariance[:2])

    def in_gate(self, position: Array, covariance: Array) -> Array:
        """Whether measured positions of the same time are within the gate of the person.

        position: (K, 2) m; covariance: (K, 2, 2) m^2, theirs. Returns (K,) bool.
        """
        apart = position - self.state[:2]
        spread = self.covariance[:2, :2] + covariance
        squared = np.einsum("ki,ki->k", apart, np.linalg.solve(spread, apart[..., None])[..., 0])
        return np.asarray(squared < GATE)
