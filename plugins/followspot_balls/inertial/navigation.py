"""State of a target that carries an inertial sensor, and how readings and positions change it.

B hypotheses that differ in heading are filtered side by side; with a known heading B is 1. The error state
has 19 components: rotation of the orientation about the axes of the room (rad), velocity (m/s), position (m),
bias of the gyroscope (rad/s) and of the accelerometer (m/s^2) and lever arm (m) in axes of the sensor, delay
(s).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.inertial.process_noise import add_noise, of_readings, without_readings
from followspot_balls.inertial.sensor_errors import GRAVITY, SensorErrors
from followspot_balls.inertial.turns import cross_matrices, turns

SIZE = 19
TURN, VELOCITY, POSITION, GYRO, ACCELERATION, ARM = (slice(i, i + 3) for i in range(0, 18, 3))
DELAY = 18
_DOWN = np.array([0.0, 0.0, -GRAVITY])
_EYE, _UNIT = np.eye(3), np.eye(SIZE)


class Navigation(NamedTuple):
    """The state at the time of a reading, of B hypotheses."""

    turn: Array
    """(B, 3, 3), rotates axes of the sensor into those of the room."""
    velocity: Array
    """(B, 3) m/s, of the sensor."""
    position: Array
    """(B, 3) m, of the sensor."""
    gyroscope_bias: Array
    """(B, 3) rad/s."""
    accelerometer_bias: Array
    """(B, 3) m/s^2."""
    lever_arm: Array
    """(B, 3) m, from the sensor to the target's position, in axes of the sensor."""
    delay: Array
    """(B,) s, time stamps of readings minus those of positions at the same moment."""
    covariance: Array
    """(B, 19, 19), of the error state."""
    turn_rate: Array
    """(B, 3) rad/s, in axes of the room."""
    acceleration: Array
    """(B, 3) m/s^2, in axes of the room, without gravity."""
    evidence: Array
    """(B,) log likelihood of the positions so far."""
    rejected: Array
    """(B,) positions in a row that did not fit."""

    def only(self, chosen: Array | list[int]) -> Navigation:
        """Some hypotheses. chosen: (B,) bool, or indices."""
        return Navigation(*(field[chosen] for field in self))


class Sight(NamedTuple):
    """What a state says of the target's position at a moment: position (B, 3) m, velocity (B, 3) m/s,
    covariance of the position (B, 3, 3) m^2, Jacobian (B, 3, 19).
    """

    position: Array
    velocity: Array
    covariance: Array
    jacobian: Array


def carried(nav: Navigation, rates: Array, forces: Array, seconds: Array, errors: SensorErrors) -> Navigation:
    """The state after K readings (section 5.4): midpoint rotations, strapdown integration.

    rates, forces: (K, 3) rad/s and m/s^2, means over the steps; seconds: (K,) lengths of the steps.
    """
    rate = rates - nav.gyroscope_bias[:, None]
    force = forces - nav.accelerometer_bias[:, None]
    step = seconds[:, None]
    halves = turns(rate * (step / 2))
    middle, turn = np.empty_like(halves), nav.turn
    for k in range(len(seconds)):
        middle[:, k] = turn @ halves[:, k]
        turn = middle[:, k] @ halves[:, k]
    gain = (middle @ force[..., None])[..., 0] * step
    speed, bend = gain.sum(axis=1), _twice(gain, step)
    spread, twice = (middle * step[..., None]).sum(axis=1), _twice(middle * step[..., None], step[..., None])
    total = float(seconds.sum())
    F = _unit(len(nav.covariance))
    F[:, VELOCITY, TURN], F[:, POSITION, TURN] = -cross_matrices(speed), -cross_matrices(bend)
    F[:, POSITION, VELOCITY] = _EYE * total
    F[:, TURN, GYRO], F[:, VELOCITY, ACCELERATION], F[:, POSITION, ACCELERATION] = -spread, -spread, -twice
    F[:, VELOCITY, GYRO] = cross_matrices(speed) @ spread / 2
    F[:, POSITION, GYRO] = cross_matrices(bend) @ spread / 3
    acceleration = gain[:, -1] / seconds[-1] + _DOWN
    covariance = F @ nav.covariance @ F.swapaxes(1, 2)
    add_noise(covariance, of_readings(rates, gain / step + _DOWN, errors), total)
    return nav._replace(
        turn=turn,
        velocity=nav.velocity + speed + _DOWN * total,
        position=nav.position + nav.velocity * total + bend + _DOWN * (total * total / 2),
        covariance=covariance,
        turn_rate=(middle[:, -1] @ rate[:, -1, :, None])[..., 0],
        acceleration=acceleration,
    )


def _unit(count: int) -> Array:
    """Identity matrices, (B, 19, 19)."""
    return np.repeat(_UNIT[None], count, axis=0)


def _twice(gain: Array, step: Array) -> Array:
    """Integral of the running sum of velocity gains: each acts half in its own step, whole in later ones."""
    later = step.sum(axis=0) - np.cumsum(step, axis=0) + step / 2
    return np.asarray((gain * later).sum(axis=1))


def coasted(nav: Navigation, seconds: float) -> Navigation:
    """The state after a time without readings: orientation and velocity stay, and grow uncertain."""
    F = np.eye(SIZE)
    F[POSITION, VELOCITY] = _EYE * seconds
    covariance = F @ nav.covariance @ F.T
    add_noise(covariance, without_readings(seconds), seconds)
    still = np.zeros_like(nav.velocity)
    position = nav.position + nav.velocity * seconds
    return nav._replace(position=position, covariance=covariance, turn_rate=still, acceleration=still)


def sighted(nav: Navigation, seconds: float) -> Sight:
    """The target's position at a capture time, `seconds` after the state's reading by the time stamps.

    p + R l + (v + w x R l) s + a s^2 / 2, with s = seconds + delay.
    """
    s = (seconds + nav.delay)[:, None]
    arm = (nav.turn @ nav.lever_arm[..., None])[..., 0]
    velocity = nav.velocity + (cross_matrices(nav.turn_rate) @ arm[..., None])[..., 0]
    H = np.zeros((len(s), 3, SIZE))
    H[:, :, TURN], H[:, :, POSITION], H[:, :, ARM] = -cross_matrices(arm), _EYE, nav.turn
    H[:, :, VELOCITY] = _EYE * s[..., None]
    H[:, :, DELAY] = velocity + nav.acceleration * s
    position = nav.position + arm + velocity * s + nav.acceleration * (s * s / 2)
    return Sight(position, velocity + nav.acceleration * s, H @ nav.covariance @ H.swapaxes(1, 2), H)


def oriented(nav: Navigation, seconds: float) -> Array:
    """Orientation at a capture time as for :func:`sighted`, (B, 3, 3)."""
    return np.asarray(turns(nav.turn_rate * (seconds + nav.delay)[:, None]) @ nav.turn)


def corrected(nav: Navigation, sight: Sight, xyz: Array, noise: Array, gate: float) -> Navigation:
    """The state corrected by a measured position: K = P H^T S^-1, P' = (I - K H) P (I - K H)^T + K R K^T.

    The errors of orientation, velocity and position turn with the corrected orientation, as in an invariant
    filter (Barrau & Bonnabel, IEEE Transactions on Automatic Control 62, 2017): large errors of the heading
    are then learnt without false certainty.

    xyz: (3,) m; noise: (3, 3) m^2, R; gate: sigmas beyond which a position is rejected by all hypotheses.
    """
    H, P = sight.jacobian, nav.covariance
    n = xyz - sight.position
    S = sight.covariance + noise
    S_inverse = np.linalg.inv(S)
    squared = (n[:, None] @ S_inverse @ n[..., None])[:, 0, 0]
    if squared.min() > gate * gate:
        return nav._replace(rejected=nav.rejected + 1)
    K = P @ H.swapaxes(1, 2) @ S_inverse
    error = (K @ n[..., None])[..., 0]
    rest = _UNIT - K @ H
    covariance = rest @ P @ rest.swapaxes(1, 2) + K @ noise @ K.swapaxes(1, 2)
    by = turns(error[:, TURN])
    along = _unit(len(P))
    along[:, TURN, TURN] = along[:, VELOCITY, VELOCITY] = along[:, POSITION, POSITION] = by
    covariance = along @ covariance @ along.swapaxes(1, 2)
    return nav._replace(
        turn=by @ nav.turn,
        velocity=nav.velocity + error[:, VELOCITY],
        position=nav.position + error[:, POSITION],
        gyroscope_bias=nav.gyroscope_bias + error[:, GYRO],
        accelerometer_bias=nav.accelerometer_bias + error[:, ACCELERATION],
        lever_arm=nav.lever_arm + error[:, ARM],
        delay=nav.delay + error[:, DELAY],
        covariance=(covariance + covariance.swapaxes(1, 2)) / 2,
        evidence=nav.evidence - (squared + np.log(np.linalg.det(S))) / 2,
        rejected=np.zeros_like(nav.rejected),
    )
