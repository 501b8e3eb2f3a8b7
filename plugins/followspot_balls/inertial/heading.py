"""The heading between sensor and room: a bank of hypotheses from which the motion chooses."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.rotation import matrix
from followspot_balls.inertial.navigation import (
    ACCELERATION,
    ARM,
    DELAY,
    GYRO,
    POSITION,
    SIZE,
    TURN,
    VELOCITY,
    Navigation,
)
from followspot_balls.inertial.sensor_errors import SensorErrors
from followspot_balls.inertial.turns import cross_matrices, turns

HYPOTHESES = 8
SPEED = 3.0
"""Sigma of the first velocity, m/s."""
IMPLAUSIBLE = 12.0
"""Log likelihood by which a hypothesis falls behind until it is dropped."""
AGREEING = np.radians(15.0)
"""Difference in heading within which all hypotheses that are left are the same."""
LEARNT = np.radians(10.0)
"""Sigma of the heading at which it is known, if they agree."""
UNSETTLED = np.radians(10.0)
"""Sigma that is added to the orientation where the positions contradict it."""
LOST = np.radians(40.0)
"""Sigma of the heading at which it is learnt anew."""


def begun(
    quaternion: Array, inclination: float, xyz: Array, noise: Array, errors: SensorErrors
) -> Navigation:
    """Hypotheses of all headings at a measured position.

    quaternion: (4,), orientation with any heading; inclination: its sigma, rad; xyz: (3,) m; noise: (3, 3)
    m^2.
    """
    count = HYPOTHESES
    up = np.zeros((count, 3))
    up[:, 2] = np.arange(count) * (2 * np.pi / count)
    variances = np.zeros(SIZE)
    variances[TURN] = inclination**2, inclination**2, (np.pi / count) ** 2
    variances[VELOCITY] = SPEED**2
    variances[GYRO], variances[ACCELERATION] = errors.gyroscope_bias**2, errors.accelerometer_bias**2
    variances[ARM], variances[DELAY] = errors.lever_arm**2, errors.delay**2
    zero = np.zeros((count, 3))
    nav = Navigation(
        turn=turns(up) @ matrix(quaternion),
        velocity=zero,
        position=zero,
        gyroscope_bias=zero,
        accelerometer_bias=zero,
        lever_arm=zero,
        delay=zero[:, 0],
        covariance=np.repeat(np.diag(variances)[None], count, axis=0),
        turn_rate=zero,
        acceleration=zero,
        evidence=zero[:, 0],
        rejected=zero[:, 0],
    )
    return _put(nav, xyz, noise)


def settled(nav: Navigation) -> Navigation:
    """The hypotheses that are left: the likely ones, or the best of those that agree."""
    if len(nav.evidence) == 1:
        return nav
    nav = nav._replace(evidence=nav.evidence - nav.evidence.max())
    nav = nav.only(nav.evidence > -IMPLAUSIBLE)
    best = int(nav.evidence.argmax())
    away = nav.turn @ nav.turn[best].T
    apart = np.abs(np.arctan2(away[:, 1, 0], away[:, 0, 0]))
    if heading_sigma(nav)[best] < LEARNT and (apart < AGREEING).all():
        return nav.only([best])
    return nav


def heading_sigma(nav: Navigation) -> Array:
    """Sigma of the heading of each hypothesis, (B,) rad."""
    return np.asarray(np.sqrt(nav.covariance[:, 2, 2]))


def is_learnt(nav: Navigation) -> bool:
    """Whether the heading is known."""
    return len(nav.evidence) == 1


def is_lost(nav: Navigation) -> bool:
    """Whether a heading that was known no longer is."""
    return is_learnt(nav) and bool(heading_sigma(nav)[0] > LOST)


def doubted(nav: Navigation, xyz: Array, noise: Array) -> Navigation | None:
    """The state begun anew at a position that contradicts it; None if its heading is no longer known.

    Biases and lever arm are kept, and so is the orientation, with a larger sigma. xyz: (3,) m; noise: (3, 3)
    m^2.
    """
    covariance = nav.covariance.copy()
    covariance[:, TURN, TURN] += np.eye(3) * UNSETTLED**2
    found = _put(nav._replace(covariance=covariance), xyz, noise)
    return None if is_lost(found) else found


def _put(nav: Navigation, xyz: Array, noise: Array) -> Navigation:
    """The state at rest where the target was measured: p = z - R l, so dp = dz - R dl + [R l]_x dtheta."""
    arm = (nav.turn @ nav.lever_arm[..., None])[..., 0]
    F = np.broadcast_to(np.eye(SIZE), nav.covariance.shape).copy()
    F[:, POSITION, POSITION] = F[:, VELOCITY, VELOCITY] = 0.0
    F[:, POSITION, ARM], F[:, POSITION, TURN] = -nav.turn, cross_matrices(arm)
    covariance = F @ nav.covariance @ F.swapaxes(1, 2)
    covariance[:, POSITION, POSITION] += noise
    covariance[:, VELOCITY, VELOCITY] += np.eye(3) * SPEED**2
    still = np.zeros_like(nav.velocity)
    return nav._replace(
        position=xyz - arm, velocity=still, covariance=covariance, rejected=np.zeros_like(nav.rejected)
    )
