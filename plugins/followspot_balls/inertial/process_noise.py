"""Growth of the error state's covariance: noise of the readings, and motion that was not read."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.inertial.sensor_errors import GRAVITY, SensorErrors

SWING = 0.2
"""Time over which a movement keeps its direction, s: errors of scale do not average out within it."""
UNREAD_ACCELERATION = 12.0
"""Sigma of the acceleration of a target without readings, m/s^2."""
UNREAD_TURN_RATE = 3.0
"""Sigma of its turn rate, rad/s."""
GYROSCOPE_WALK = 2e-5
"""Density of the walk of the gyroscope's bias, rad/s^2/sqrt(Hz)."""
ACCELEROMETER_WALK = 2e-4
"""Density of the walk of the accelerometer's bias, m/s^3/sqrt(Hz)."""

DELAY_WALK = 1e-4
"""Density of the walk of the delay, s/sqrt(s); drifts of 200 ppm are followed within a millisecond."""


class Densities(NamedTuple):
    """Spectral densities of white noise."""

    rotation: float
    """rad^2/s, of the turn rate."""
    force: float
    """m^2/s^3, of the acceleration."""
    gyroscope_bias: float
    """rad^2/s^3."""
    accelerometer_bias: float
    """m^2/s^5."""


def of_readings(rates: Array, accelerations: Array, errors: SensorErrors) -> Densities:
    """Densities while readings come. rates: (K, 3) rad/s; accelerations: (K, 3) m/s^2, without gravity.

    An error of scale acts as noise that is correlated over a swing. An accelerometer that turns feels gravity
    along another axis, with another error, so its apparent bias walks with the angle.
    """
    turning = float(np.vdot(rates, rates)) / len(rates)
    moving = float(np.vdot(accelerations, accelerations)) / len(accelerations)
    return Densities(
        errors.gyroscope_noise**2 + errors.gyroscope_scale**2 * turning * SWING,
        errors.accelerometer_noise**2 + errors.accelerometer_scale**2 * moving * SWING,
        GYROSCOPE_WALK**2,
        ACCELEROMETER_WALK**2 + (errors.accelerometer_scale * GRAVITY) ** 2 * sqrt(turning),
    )


def without_readings(seconds: float) -> Densities:
    """Densities over a step without readings, in which the motion is constant but unknown."""
    return Densities(UNREAD_TURN_RATE**2 * seconds, UNREAD_ACCELERATION**2 * seconds, 0.0, 0.0)


def add_noise(covariance: Array, densities: Densities, seconds: float) -> None:
    """Add the noise of a step to a contiguous (19, 19) in place; components as in `Navigation`."""
    size = len(covariance)
    cells = covariance.reshape(-1)
    diagonal = cells[:: size + 1]
    diagonal[0:3] += densities.rotation * seconds
    diagonal[3:6] += densities.force * seconds
    diagonal[6:9] += densities.force * (seconds**3 / 3)
    diagonal[9:12] += densities.gyroscope_bias * seconds
    diagonal[12:15] += densities.accelerometer_bias * seconds
    diagonal[18] += DELAY_WALK**2 * seconds
    both = densities.force * (seconds**2 / 2)
    for row, column in ((3, 6), (6, 3)):  # velocity and position
        first = row * size + column
        cells[first : first + 2 * size + 3 : size + 1] += both
