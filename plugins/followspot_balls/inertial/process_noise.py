"""Growth of the error state's covariance: noise of the readings, and motion that was not read."""

from __future__ import annotations

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


class Densities(NamedTuple):
    """Spectral densities of white noise, (B,) or numbers."""

    turn: Array | float
    """rad^2/s, of the turn rate."""
    force: Array | float
    """m^2/s^3, of the acceleration."""
    gyroscope_bias: Array | float
    """rad^2/s^3."""
    accelerometer_bias: Array | float
    """m^2/s^5."""


def of_readings(rates: Array, accelerations: Array, errors: SensorErrors) -> Densities:
    """Densities while readings come. rates: (K, 3) rad/s; accelerations: (B, K, 3) m/s^2, without gravity.

    An error of scale acts as noise that is correlated over a swing. An accelerometer that turns feels gravity
    along another axis, with another error, so its apparent bias walks with the angle.
    """
    turning = float(np.vecdot(rates, rates).mean())
    moving = np.vecdot(accelerations, accelerations).mean(axis=1)
    return Densities(
        errors.gyroscope_noise**2 + errors.gyroscope_scale**2 * turning * SWING,
        errors.accelerometer_noise**2 + errors.accelerometer_scale**2 * moving * SWING,
        GYROSCOPE_WALK**2,
        ACCELEROMETER_WALK**2 + (errors.accelerometer_scale * GRAVITY) ** 2 * np.sqrt(turning),
    )


def without_readings(seconds: float) -> Densities:
    """Densities over a step without readings, in which the motion is constant but unknown."""
    return Densities(UNREAD_TURN_RATE**2 * seconds, UNREAD_ACCELERATION**2 * seconds, 0.0, 0.0)


def add_noise(covariance: Array, densities: Densities, seconds: float) -> None:
    """Add the noise of a step to (B, 19, 19) in place; components as in `Navigation`."""
    i = np.arange(3)
    turn, velocity, position, gyroscope, accelerometer = i, i + 3, i + 6, i + 9, i + 12
    force = np.atleast_1d(densities.force)[:, None]
    covariance[:, turn, turn] += np.atleast_1d(densities.turn)[:, None] * seconds
    covariance[:, velocity, velocity] += force * seconds
    covariance[:, position, position] += force * (seconds**3 / 3)
    covariance[:, velocity, position] += force * (seconds**2 / 2)
    covariance[:, position, velocity] += force * (seconds**2 / 2)
    covariance[:, gyroscope, gyroscope] += np.atleast_1d(densities.gyroscope_bias)[:, None] * seconds
    covariance[:, accelerometer, accelerometer] += (
        np.atleast_1d(densities.accelerometer_bias)[:, None] * seconds
    )
