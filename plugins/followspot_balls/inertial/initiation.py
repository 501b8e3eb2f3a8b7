"""Initiation of a navigation, also anew when the positions contradict it."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.rotation import matrix
from followspot_balls.inertial.heading import SPEED
from followspot_balls.inertial.navigation import (
    ACCELERATION,
    ARM,
    DELAY,
    GYRO,
    POSITION,
    ROTATION,
    SIZE,
    VELOCITY,
    Navigation,
)
from followspot_balls.inertial.rotation_matrices import cross_matrices
from followspot_balls.inertial.sensor_errors import SensorErrors

ADDED_SIGMA = np.radians(10.0)
"""Sigma that is added to the orientation when the positions contradict it."""
LOST_SIGMA = np.radians(40.0)
"""Sigma of the heading at which it is searched anew."""


def initiated(quaternion: Array, sigma: Array, xyz: Array, noise: Array, errors: SensorErrors) -> Navigation:
    """The state at a measured position, with an orientation.

    quaternion: (4,); sigma: (3,) rad, of the orientation about the axes of the room; xyz: (3,) m; noise:
    (3, 3) m^2.
    """
    variances = np.zeros(SIZE)
    variances[ROTATION] = np.square(sigma)
    variances[GYRO], variances[ACCELERATION] = errors.gyroscope_bias**2, errors.accelerometer_bias**2
    variances[ARM], variances[DELAY] = errors.lever_arm**2, errors.delay**2
    zero = np.zeros(3)
    nav = Navigation(
        rotation=np.ascontiguousarray(matrix(quaternion)),
        velocity=zero,
        position=zero,
        gyroscope_bias=zero,
        accelerometer_bias=zero,
        lever_arm=zero,
        delay=0.0,
        covariance=np.diag(variances),
        turn_rate=zero,
        acceleration=zero,
        rejected=0,
    )
    return _at_rest(nav, xyz, noise)


def heading_sigma(nav: Navigation) -> float:
    """Sigma of the heading, rad."""
    return float(np.sqrt(nav.covariance[2, 2]))


def heading_difference(nav: Navigation, quaternion: Array) -> float:
    """Heading of an orientation, (4,), relative to that of the navigation, rad."""
    away = matrix(quaternion) @ nav.rotation.T
    return float(np.arctan2(away[1, 0] - away[0, 1], away[0, 0] + away[1, 1]))


def with_heading_error(nav: Navigation, error: float) -> Navigation:
    """The navigation with a larger sigma of the heading, for one that may be wrong by an angle, rad."""
    covariance = nav.covariance.copy()
    covariance[2, 2] += error * error
    return nav._replace(covariance=covariance)


def heading_is_lost(nav: Navigation) -> bool:
    """Whether the heading is no longer known."""
    return bool(heading_sigma(nav) > LOST_SIGMA)


def reinitiated(nav: Navigation, xyz: Array, noise: Array) -> Navigation | None:
    """The state initiated anew at a position that contradicts it; None if its heading is lost.

    Biases and lever arm are kept, and so is the orientation, with a larger sigma. xyz: (3,) m; noise: (3, 3)
    m^2.
    """
    covariance = nav.covariance.copy()
    covariance[ROTATION, ROTATION] += np.eye(3) * ADDED_SIGMA**2
    found = _at_rest(nav._replace(covariance=covariance), xyz, noise)
    return None if heading_is_lost(found) else found


def _at_rest(nav: Navigation, xyz: Array, noise: Array) -> Navigation:
    """The state at rest where the target was measured: p = z - R l, so dp = dz - R dl + [R l]_x dtheta."""
    arm = nav.rotation @ nav.lever_arm
    F = np.eye(SIZE)
    F[POSITION, POSITION] = F[VELOCITY, VELOCITY] = 0.0
    F[POSITION, ARM], F[POSITION, ROTATION] = -nav.rotation, cross_matrices(arm)
    covariance = F @ nav.covariance @ F.T
    covariance[POSITION, POSITION] += noise
    covariance[VELOCITY, VELOCITY] += np.eye(3) * SPEED**2
    return nav._replace(position=xyz - arm, velocity=np.zeros(3), covariance=covariance, rejected=0)
