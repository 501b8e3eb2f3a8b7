"""The errors of a sensor's readings that the filter assumes."""

from __future__ import annotations

from dataclasses import dataclass

GRAVITY = 9.81
"""m/s^2; where the true one differs, the accelerometer's bias takes the difference up."""


@dataclass(frozen=True)
class SensorErrors:
    """Standard deviations of the errors of an inertial sensor and of its mounting."""

    gyroscope_noise: float
    """Density of the white noise, rad/s/sqrt(Hz)."""
    accelerometer_noise: float
    """Density of the white noise, m/s^2/sqrt(Hz)."""
    gyroscope_scale: float
    """Error relative to the turn rate: sensitivity and misaligned axes."""
    accelerometer_scale: float
    """Error relative to the force: sensitivity and misaligned axes."""
    gyroscope_bias: float
    """rad/s."""
    accelerometer_bias: float
    """m/s^2."""
    lever_arm: float
    """Distance of the accelerometer from the target's position along each axis, m."""
    delay: float
    """Time stamps of the readings minus those of the positions, s."""
