"""The steady course of each target: a ball that rolls keeps to it, one that is picked up leaves it."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from followspot.messages import Array

SETTLING = 0.2
"""Time constant of the course, s. A ball that rolls and slows by 1 m/s^2 leaves it by 4 cm."""


class Course(NamedTuple):
    """Place and velocity of T targets, without what changed in the last tenths of a second."""

    place: Array
    """(T, 3) m."""
    velocity: Array
    """(T, 3) m/s."""
    known: Array
    """(T,) bool, whether a target has a course."""

    @classmethod
    def unknown(cls, count: int) -> Self:
        """No target has a course."""
        return cls(np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count, bool))

    def stray(self, xyz: Array, target: Array | slice, seconds: float) -> Array:
        """How far some targets are from their courses that many seconds later, (M, 3) m; 0 without one.

        xyz: (M, 3) m; target: (M,) their numbers.
        """
        course = self.place[target] + seconds * self.velocity[target]
        return np.asarray((xyz - course) * self.known[target][:, None])

    def followed(self, xyz: Array, tracked: Array, seconds: float) -> Self:
        """The course one frame later, by a critically damped g-h filter (Brookner 1998, section 1.2.6).

        xyz: (T, 3) m; tracked: (T,) bool, others lose their course; seconds: of the frame.
        """
        error = self.stray(xyz, slice(None), seconds)
        memory = np.exp(-seconds / SETTLING)
        gain = (1 - memory) ** 2 / seconds if seconds > 0 else 0.0
        goes_on = (tracked & self.known)[:, None]
        return self._replace(
            place=np.where(goes_on, xyz - memory**2 * error, xyz),
            velocity=np.where(goes_on, self.velocity + gain * error, 0.0),
            known=tracked.copy(),
        )
