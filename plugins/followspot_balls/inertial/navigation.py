"""State of a target that carries an inertial sensor, and how readings and positions change it.

The error state has 19 components: rotation of the orientation about the axes of the room (rad), velocity
(m/s), position (m), bias of the gyroscope (rad/s) and of the accelerometer (m/s^2) and lever arm (m) in axes
of the sensor, delay (s).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.inertial.process_noise import add_noise, of_readings, without_readings
from followspot_balls.inertial.rotation_matrices import cross_matrices, rotation_exp
from followspot_balls.inertial.sensor_errors import GRAVITY, SensorErrors

SIZE = 19
ROTATION, VELOCITY, POSITION, GYRO, ACCELERATION, ARM = (slice(i, i + 3) for i in range(0, 18, 3))
DELAY = 18
_DOWN = np.array([0.0, 0.0, -GRAVITY])
_EYE, _UNIT = np.eye(3), np.eye(SIZE)


class Navigation(NamedTuple):
    """The state at the time of a reading."""

    rotation: Array
    """(3, 3), rotates axes of the sensor into those of the room."""
    velocity: Array
    """(3,) m/s, of the sensor."""
    position: Array
    """(3,) m, of the sensor."""
    gyroscope_bias: Array
    """(3,) rad/s."""
    accelerometer_bias: Array
    """(3,) m/s^2."""
    lever_arm: Array
    """(3,) m, from the sensor to the target's position, in axes of the sensor."""
    delay: float
    """s, time stamps of readings minus those of positions at the same moment."""
    covariance: Array
    """(19, 19), of the error state."""
    turn_rate: Array
    """(3,) rad/s, in axes of the room."""
    acceleration: Array
    """(3,) m/s^2, in axes of the room, without gravity."""
    rejected: int
    """Positions in a row that did not fit."""

    def plain(self) -> dict[str, Array]:
        """Arrays, for a checkpoint."""
        return {name: np.array(value) for name, value in self._asdict().items()}

    @classmethod
    def restored(cls, plain: Mapping[str, Array]) -> Navigation:
        """The state of a checkpoint."""
        arrays: dict[str, Any] = {name: np.array(plain[name]) for name in cls._fields}
        return cls(**arrays | {"delay": float(plain["delay"]), "rejected": int(plain["rejected"])})


class PredictedPosition(NamedTuple):
    """Prediction of the target's measured position at a capture time.

    position: (3,) m; velocity: (3,) m/s; covariance: of the position, (3, 3) m^2; jacobian: (3, 19).
    """

    position: Array
    velocity: Array
    covariance: Array
    jacobian: Array


def propagated(
    nav: Navigation, rates: Array, forces: Array, seconds: Array, errors: SensorErrors
) -> Navigation:
    """The state after K readings (section 5.4): midpoint rotations, strapdown integration.

    rates, forces: (K, 3) rad/s and m/s^2, means over the steps; seconds: (K,) lengths of the steps.
    """
    rate, force, step = rates - nav.gyroscope_bias, forces - nav.accelerometer_bias, seconds[:, None]
    halves, rotation = rotation_exp(rate * (step / 2)), nav.rotation
    middle = np.empty_like(halves)
    for half, between in zip(halves, middle, strict=True):
        np.matmul(rotation, half, out=between)
        rotation = between @ half
    gain = (middle @ force[..., None])[..., 0] * step
    total = float(seconds.sum())
    later = (total - seconds.cumsum() + seconds / 2) * seconds
    spread = (seconds @ middle.reshape(-1, 9)).reshape(3, 3)
    twice = (later @ middle.reshape(-1, 9)).reshape(3, 3)
    speed, bend = gain.sum(axis=0), (later / seconds) @ gain
    across_speed, across_bend = cross_matrices(speed), cross_matrices(bend)
    F = _UNIT.copy()
    F[VELOCITY, ROTATION], F[POSITION, ROTATION] = -across_speed, -across_bend
    F[POSITION, VELOCITY] = _EYE * total
    F[ROTATION, GYRO] = F[VELOCITY, ACCELERATION] = -spread
    F[POSITION, ACCELERATION] = -twice
    F[VELOCITY, GYRO] = across_speed @ spread / 2
    F[POSITION, GYRO] = across_bend @ spread / 3
    covariance = F @ nav.covariance @ F.T
    add_noise(covariance, of_readings(rates, gain / step + _DOWN, errors), total)
    return nav._replace(
        rotation=rotation,
        velocity=nav.velocity + speed + _DOWN * total,
        position=nav.position + nav.velocity * total + bend + _DOWN * (total * total / 2),
        covariance=covariance,
        turn_rate=middle[-1] @ rate[-1],
        acceleration=gain[-1] / seconds[-1] + _DOWN,
    )


def coasted(nav: Navigation, seconds: float) -> Navigation:
    """The state after a time without readings: orientation and velocity stay, and grow uncertain."""
    F = _UNIT.copy()
    F[POSITION, VELOCITY] = _EYE * seconds
    covariance = F @ nav.covariance @ F.T
    add_noise(covariance, without_readings(seconds), seconds)
    still = np.zeros(3)
    position = nav.position + nav.velocity * seconds
    return nav._replace(position=position, covariance=covariance, turn_rate=still, acceleration=still)


def predicted_position(nav: Navigation, seconds: float) -> PredictedPosition:
    """The position of the target at a capture time, `seconds` after the state's reading by the time stamps.

    p + R l + (v + w x R l) s + a s^2 / 2, with s = seconds + delay.
    """
    s = seconds + nav.delay
    arm = nav.rotation @ nav.lever_arm
    across = cross_matrices(arm)
    velocity = nav.velocity - across @ nav.turn_rate
    later = velocity + nav.acceleration * s
    H = np.zeros((3, SIZE))
    H[:, ROTATION], H[:, POSITION], H[:, ARM] = -across, _EYE, nav.rotation
    H[:, VELOCITY] = _EYE * s
    H[:, DELAY] = later
    position = nav.position + arm + velocity * s + nav.acceleration * (s * s / 2)
    return PredictedPosition(position, later, H @ nav.covariance @ H.T, H)


def predicted_orientation(nav: Navigation, seconds: float) -> Array:
    """Orientation at a capture time as for :func:`predicted_position`, (3, 3)."""
    return np.asarray(rotation_exp(nav.turn_rate * (seconds + nav.delay)) @ nav.rotation)


def corrected(
    nav: Navigation, predicted: PredictedPosition, xyz: Array, noise: Array, gate: float
) -> Navigation:
    """The state corrected by a measured position: K = P H^T S^-1, P' = (I - K H) P (I - K H)^T + K R K^T.

    The errors of orientation, velocity and position turn with the corrected orientation, as in an invariant
    filter (Barrau & Bonnabel, IEEE Transactions on Automatic Control 62, 2017): large errors of the heading
    are then learnt without false certainty.

    xyz: (3,) m; noise: (3, 3) m^2, R; gate: sigmas beyond which a position is rejected.
    """
    H, P = predicted.jacobian, nav.covariance
    n = xyz - predicted.position
    S_inverse = np.linalg.inv(predicted.covariance + noise)
    if n @ S_inverse @ n > gate * gate:
        return nav._replace(rejected=nav.rejected + 1)
    K = P @ H.T @ S_inverse
    error = K @ n
    rest = _UNIT - K @ H
    correction = rotation_exp(error[ROTATION])
    along = _UNIT.copy()
    along[ROTATION, ROTATION] = along[VELOCITY, VELOCITY] = along[POSITION, POSITION] = correction
    covariance = along @ (rest @ P @ rest.T + K @ noise @ K.T) @ along.T
    return nav._replace(
        rotation=correction @ nav.rotation,
        velocity=nav.velocity + error[VELOCITY],
        position=nav.position + error[POSITION],
        gyroscope_bias=nav.gyroscope_bias + error[GYRO],
        accelerometer_bias=nav.accelerometer_bias + error[ACCELERATION],
        lever_arm=nav.lever_arm + error[ARM],
        delay=nav.delay + float(error[DELAY]),
        covariance=(covariance + covariance.T) / 2,
        rejected=0,
    )
