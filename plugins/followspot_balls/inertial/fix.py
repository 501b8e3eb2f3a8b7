"""Position fix: position and orientation of one target at a capture time, by its navigation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_balls.inertial.frame_state import GATE, MAXIMUM_REJECTED, FrameState
from followspot_balls.inertial.initiation import heading_is_lost
from followspot_balls.inertial.navigation import ROTATION, predicted_orientation, predicted_position
from followspot_balls.inertial.process_noise import UNREAD_ACCELERATION
from followspot_balls.inertial.rotation_matrices import quaternion_of

MAXIMUM_SIGMA = np.radians(10.0)
"""Sigma of the heading during its search, rad, beyond which the orientation is not reported."""


class Fix(NamedTuple):
    """Position and orientation of one target.

    xyz: (3,) m; velocity: (3,) m/s; covariance: of the position, (3, 3) m^2; quaternion: (4,), from axes of
    the sensor to those of the room; orientation_sigma: rad; both are NaN while the heading is uncertain;
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
        return bool(squared > GATE * GATE) and self.contradicted + 1 < MAXIMUM_REJECTED


def fix_at(frame_state: FrameState | None, time: int, ahead: float = 0.0) -> Fix | None:
    """The target at a capture time, ns, or `ahead` seconds after it without further readings.

    None if the heading is not known.
    """
    if frame_state is None or frame_state.nav is None:
        return None
    nav = frame_state.nav
    if heading_is_lost(nav):
        return None
    seconds = (time - frame_state.read) * NANOSECOND + ahead
    predicted = predicted_position(nav, seconds)
    unread = np.eye(3) * (UNREAD_ACCELERATION * ahead * ahead / 2) ** 2
    quaternion, orientation_sigma = _orientation(frame_state, seconds)
    return Fix(
        predicted.position,
        predicted.velocity,
        predicted.covariance + unread,
        quaternion,
        orientation_sigma,
        nav.rejected,
    )


def _orientation(frame_state: FrameState, seconds: float) -> tuple[Array, float]:
    """Quaternion (4,) and its sigma, rad, some seconds after the reading."""
    nav, search = frame_state.nav, frame_state.search
    assert nav is not None
    sigma = float(np.sqrt(nav.covariance[ROTATION, ROTATION].trace()))
    if search is not None:
        sigma = max(sigma, search.sigma)
        if sigma > MAXIMUM_SIGMA:
            return np.full(4, np.nan), np.nan
    return quaternion_of(predicted_orientation(nav, seconds)), sigma
