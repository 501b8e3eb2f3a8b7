"""Search for the heading between sensor and room, from the motion alone, before a navigation can begin.

Two horizontal paths are compared, as complex numbers x + iy: that of the positions, z, and that of the
readings, integrated twice in axes with z upward and any heading. But for errors, z is the second times
e^(i psi). A Kalman filter of position, velocity and error of the acceleration whitens both. It is linear and
the same along both axes, so the innovations n of the positions alone and m of the readings alone give the
likelihood of every heading: log L = -sum |e^(-i psi) n - m|^2 / 2S = const + Re(e^(-i psi) C), with
C = sum n conj(m) / S. This is a von Mises distribution about arg C with the concentration |C| (Mardia & Jupp,
Directional Statistics, 2000, section 3.5.4). Nothing is linearised about a heading: at rest all stay likely.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_balls.inertial.process_noise import SWING, UNREAD_ACCELERATION, UNREAD_TURN_RATE
from followspot_balls.inertial.sensor_errors import GRAVITY, SensorErrors

SPEED = 3.0
"""Sigma of the first velocity, m/s."""
LEVELLING = 3.0
"""Time over which the inclination's error changes, s: that of filters of orientation."""
HEADING_WALK = np.radians(0.5)
"""Density of the walk of the heading that the orientations have, rad/sqrt(s)."""


class Steps(NamedTuple):
    """K readings since the last.

    read: capture time of the newest, ns; seconds: (K,) of each step; force: (K,) m/s^2, horizontal, complex,
    at its end; turn_rate: (K,) rad/s; inclination: sigma of the last, rad.
    """

    read: int
    seconds: Array
    force: Array
    turn_rate: Array
    inclination: float


class HeadingSearch(NamedTuple):
    """State of the search at the time of a reading."""

    read: int
    """That time, ns."""
    states: Array
    """(3, 2) complex: position m, velocity m/s, error of acceleration m/s^2; of positions, of readings."""
    covariance: Array
    """(3, 3), of each."""
    force: complex
    """m/s^2, of the reading."""
    evidence: complex
    """C: its angle is the likeliest heading, its length the concentration."""
    rejected: int
    """Positions in a row that fit no heading."""

    def plain(self) -> dict[str, Array]:
        """Arrays, for a checkpoint."""
        return {name: np.array(value) for name, value in self._asdict().items()}

    @classmethod
    def restored(cls, plain: Mapping[str, Array]) -> HeadingSearch:
        """The search of a checkpoint."""
        force, evidence = complex(plain["force"]), complex(plain["evidence"])
        states, covariance = np.array(plain["states"]), np.array(plain["covariance"])
        return cls(int(plain["read"]), states, covariance, force, evidence, int(plain["rejected"]))

    @property
    def heading(self) -> float:
        """The likeliest heading, rad: rotates the axes of the orientations into those of the room."""
        return float(np.angle(self.evidence))

    @property
    def sigma(self) -> float:
        """One standard deviation of the heading, rad; infinite if nothing is known."""
        return float(1 / np.sqrt(max(abs(self.evidence), 1e-12)))


def search_initiated(
    read: int, xyz: Array, noise: Array, force: complex, inclination: float, errors: SensorErrors
) -> HeadingSearch:
    """The search at a measured position.

    read: capture time of the last reading, ns; xyz: (3,) m; noise: (3, 3) m^2; force: m/s^2; inclination:
    rad.
    """
    states = np.zeros((3, 2), complex)
    states[0, 0] = complex(xyz[0], xyz[1])
    error = _acceleration_error(inclination, errors)
    covariance = np.diag([_horizontal(noise), SPEED**2, error**2])
    return HeadingSearch(read, states, covariance, force, 0j, 0)


def search_propagated(search: HeadingSearch, steps: Steps, errors: SensorErrors) -> HeadingSearch:
    """The search after K readings. A lever arm's unknown centripetal force counts as noise of a swing."""
    total = float(steps.seconds.sum())
    means = (np.append(search.force, steps.force[:-1]) + steps.force) / 2
    gains = means * steps.seconds
    later = total - np.cumsum(steps.seconds) + steps.seconds / 2
    kept = np.exp(-total / LEVELLING)
    F = np.array([[1.0, total, total * total / 2], [0.0, 1.0, total], [0.0, 0.0, kept]])
    states = F @ search.states
    states[:2, 1] += (gains * later).sum(), gains.sum()
    turning = float(np.square(steps.turn_rate).mean())
    moving = float(np.square(np.abs(means)).mean())
    swing = errors.accelerometer_scale**2 * moving + errors.lever_arm**2 * turning**2
    white = errors.accelerometer_noise**2 + swing * SWING
    error = _acceleration_error(steps.inclination, errors) ** 2
    covariance = F @ search.covariance @ F.T + _walk(white, total)
    covariance[2, 2] += error * (1 - kept * kept)
    drift = (HEADING_WALK**2 + errors.gyroscope_scale**2 * turning * SWING) * total
    return search._replace(
        read=steps.read,
        states=states,
        covariance=covariance,
        force=complex(steps.force[-1]),
        evidence=_diffused(search.evidence, drift),
    )


def search_coasted(search: HeadingSearch, read: int) -> HeadingSearch:
    """The search at a later time, ns, without readings: neither motion nor turning is known."""
    seconds = (read - search.read) * NANOSECOND
    F = np.array([[1.0, seconds, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    covariance = F @ search.covariance @ F.T + _walk(UNREAD_ACCELERATION**2 * seconds, seconds)
    evidence = _diffused(search.evidence, (UNREAD_TURN_RATE * seconds) ** 2)
    return search._replace(read=read, states=F @ search.states, covariance=covariance, evidence=evidence)


def search_corrected(
    search: HeadingSearch, time: int, xyz: Array, noise: Array, gate: float
) -> HeadingSearch:
    """The search after a measured position.

    time: of the position, ns; xyz: (3,) m; noise: (3, 3) m^2; gate: sigmas beyond which a position is
    rejected, whatever the heading.
    """
    seconds = (time - search.read) * NANOSECOND
    H = np.array([1.0, seconds, seconds * seconds / 2])
    predicted = H @ search.states
    predicted[1] += search.force * H[2]
    S = float(H @ search.covariance @ H) + _horizontal(noise)
    measured, read = complex(xyz[0], xyz[1]) - predicted[0], predicted[1]
    if (abs(measured) - abs(read)) ** 2 > gate * gate * S:
        return search._replace(rejected=search.rejected + 1)
    K = search.covariance @ H / S
    return search._replace(
        states=search.states + np.outer(K, [measured, -read]),
        covariance=search.covariance - np.outer(K, K) * S,
        evidence=search.evidence + measured * read.conjugate() / S,
        rejected=0,
    )


def _horizontal(noise: Array) -> float:
    """Variance along a horizontal axis, m^2. noise: (3, 3)."""
    return float(noise[0, 0] + noise[1, 1]) / 2


def _acceleration_error(inclination: float, errors: SensorErrors) -> float:
    """Sigma along an axis, m/s^2: gravity in wrong axes, and the accelerometer's bias."""
    return float(np.hypot(GRAVITY * inclination, errors.accelerometer_bias))


def _walk(density: float, seconds: float) -> Array:
    """Covariance after white noise of acceleration, (3, 3). density: m^2/s^3."""
    found = np.zeros((3, 3))
    found[:2, :2] = [[seconds**3 / 3, seconds**2 / 2], [seconds**2 / 2, seconds]]
    return density * found


def _diffused(evidence: complex, variance: float) -> complex:
    """The evidence after the heading has walked by this variance, rad^2: variances, 1 / |C|, add."""
    return evidence / (1 + abs(evidence) * variance)
