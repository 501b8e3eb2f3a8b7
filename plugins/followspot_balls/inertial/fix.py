"""What the navigation of one target says at a capture time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_balls.inertial.beginning import is_lost
from followspot_balls.inertial.checkpoint import CONTRADICTIONS, GATE, Checkpoint
from followspot_balls.inertial.navigation import TURN, oriented, sighted
from followspot_balls.inertial.process_noise import UNREAD_ACCELERATION
from followspot_balls.inertial.turns import quaternion_of

VAGUE = np.radians(10.0)
"""Sigma of the heading while it is sought, from which on the orientation is not told."""


class Fix(NamedTuple):
    """One target.

    xyz: (3,) m; velocity: (3,) m/s; covariance: of the position, (3, 3) m^2; quaternion: (4,), from axes of
    the sensor to those of the room; orientation_sigma: rad; both are NaN while the heading is vague;
    contradicted: positions in successive frames that did not fit.
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

    def surer_than(self, other: Fix) -> bool:
        """Whether the largest sigma of the position is below that of the other fix."""
        return bool(self.sigma.max() < other.sigma.max())

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
    if is_lost(nav):
        return None
    seconds = (time - checkpoint.read) * NANOSECOND + ahead
    sight = sighted(nav, seconds)
    unread = np.eye(3) * (UNREAD_ACCELERATION * ahead * ahead / 2) ** 2
    quaternion, orientation_sigma = _orientation(checkpoint, seconds)
    return Fix(
        sight.position,
        sight.velocity,
        sight.covariance + unread,
        quaternion,
        orientation_sigma,
        nav.rejected,
    )


def _orientation(checkpoint: Checkpoint, seconds: float) -> tuple[Array, float]:
    """Quaternion (4,) and its sigma, rad, some seconds after the reading."""
    nav, search = checkpoint.nav, checkpoint.search
    assert nav is not None
    sigma = float(np.sqrt(nav.covariance[TURN, TURN].trace()))
    if search is not None:
        sigma = max(sigma, search.sigma)
        if sigma > VAGUE:
            return np.full(4, np.nan), np.nan
    return quaternion_of(oriented(nav, seconds)), sigma
