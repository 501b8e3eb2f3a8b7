"""The steady motion of each target: a ball that rolls keeps to it, one that is picked up leaves it."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from followspot.messages import Array

SETTLING = 0.2
"""Time constant of the filter, s. A ball that rolls and slows by 1 m/s^2 deviates by 4 cm."""


class SteadyMotion(NamedTuple):
    """Position and velocity of T targets, without the changes of the last tenths of a second."""

    xyz: Array
    """(T, 3) m."""
    velocity: Array
    """(T, 3) m/s."""
    known: Array
    """(T,) bool, whether the steady motion of a target is known."""

    @classmethod
    def unknown(cls, count: int) -> Self:
        """The motion of no target is known."""
        return cls(np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count, bool))

    def deviation(self, xyz: Array, target: Array | slice, seconds: float) -> Array:
        """Positions minus where the steady motion leads in that many seconds, (M, 3) m; 0 if it is unknown.

        xyz: (M, 3) m; target: (M,) their numbers.
        """
        expected = self.xyz[target] + seconds * self.velocity[target]
        return np.asarray((xyz - expected) * self.known[target][:, None])

    def updated(self, xyz: Array, tracked: Array, seconds: float) -> Self:
        """The motion one frame later, by a critically damped g-h filter (Brookner 1998, section 1.2.6).

        xyz: (T, 3) m; tracked: (T,) bool, the motion of others becomes unknown; seconds: of the frame.
        """
        deviation = self.deviation(xyz, slice(None), seconds)
        memory = np.exp(-seconds / SETTLING)
        gain = (1 - memory) ** 2 / seconds if seconds > 0 else 0.0
        continued = (tracked & self.known)[:, None]
        return self._replace(
            xyz=np.where(continued, xyz - memory**2 * deviation, xyz),
            velocity=np.where(continued, self.velocity + gain * deviation, 0.0),
            known=tracked.copy(),
        )
