"""What the navigation of one target says at a capture time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.inertial.heading import is_learnt, is_lost
from followspot_balls.inertial.navigation import TURN, oriented, sighted
from followspot_balls.inertial.navigator import CONTRADICTIONS, GATE, NANOSECOND, Checkpoint
from followspot_balls.inertial.process_noise import UNREAD_ACCELERATION
from followspot_balls.inertial.turns import quaternion_of


class Fix(NamedTuple):
    """One target: xyz (3,) m, velocity (3,) m/s, covariance (3, 3) m^2 of the position, quaternion (4,) from
    axes of the sensor to those of the room, orientation_sigma in rad; contradicted: positions in successive
    frames that did not fit.
    """

    xyz: Array
    velocity: Array
    covariance: Array
    quaternion: Array
    orientation_sigma: float
    contradicted: int

    @property
    def sigma(self) -> Array:
        """(3,) m, along each axis."""
        return np.asarray(np.sqrt(self.covariance.diagonal()))

    def rejects(self, xyz: Array, noise: Array) -> bool:
        """Whether a position contradicts the sensor, and is not one of many. xyz: (3,) m; noise: (3, 3)."""
        offset = xyz - self.xyz
        squared = offset @ np.linalg.solve(self.covariance + noise, offset)
        return bool(squared > GATE * GATE) and self.contradicted + 1 < CONTRADICTIONS


def fix_at(checkpoint: Checkpoint | None, time: int, ahead: float = 0.0) -> Fix | None:
    """The target at a capture time, ns, or `ahead` seconds after it without further readings.

    None if the heading is not known.
    """
    if checkpoint is None or checkpoint.nav is None:
        return None
    nav = checkpoint.nav
    if not is_learnt(nav) or is_lost(nav):
        return None
    seconds = (time - checkpoint.read) * NANOSECOND + ahead
    sight = sighted(nav, seconds)
    unread = np.eye(3) * (UNREAD_ACCELERATION * ahead * ahead / 2) ** 2
    return Fix(
        sight.position[0],
        sight.velocity[0],
        sight.covariance[0] + unread,
        quaternion_of(oriented(nav, seconds)[0]),
        float(np.sqrt(np.trace(nav.covariance[0, TURN, TURN]))),
        int(nav.rejected[0]),
    )
