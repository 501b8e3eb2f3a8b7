"""The Kalman filter of first-order motion, for all targets at once (Jin & Qian 2008, section 3.7)."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np

from followspot.messages import Array
from followspot_target_filter.association_probability import association_probability, mixed
from followspot_target_filter.manoeuvre import Bounces, slowing_covariance, sudden_covariance


class Motion(NamedTuple):
    """Position and velocity of T targets: state (T, 6) in m and m/s, covariance (T, 6, 6)."""

    state: Array
    covariance: Array

    @classmethod
    def zero(cls, count: int) -> Self:
        """The motion of `count` targets before any measurement."""
        return cls(np.zeros((count, 6)), np.zeros((count, 6, 6)))

    @property
    def xyz(self) -> Array:
        """(T, 3) m."""
        return self.state[:, :3]

    @property
    def velocity(self) -> Array:
        """(T, 3) m/s."""
        return self.state[:, 3:]

    @property
    def sigma(self) -> Array:
        """(T, 3) m, of the place along each axis."""
        return np.asarray(np.sqrt(self.covariance.diagonal(axis1=1, axis2=2)[:, :3]))


def initiated(motion: Motion, target: Array, xyz: Array, noise: Array, speed: float) -> Motion:
    """The motion with some targets initiated: at rest where they were measured.

    target: (M,); xyz: (M, 3) m; noise: (M, 3, 3) m^2; speed: one sigma of the velocity, m/s.
    """
    state, covariance = motion.state.copy(), motion.covariance.copy()
    state[target, :3], state[target, 3:] = xyz, 0.0
    covariance[target] = 0.0
    covariance[target, :3, :3] = noise
    covariance[target, 3:, 3:] = np.eye(3) * speed**2
    return Motion(state, covariance)


def predict(motion: Motion, seconds: float, acceleration: float) -> Motion:
    """One step ahead: x' = F x, P' = F P F^T + Q, with Q of a piecewise constant acceleration.

    acceleration: one sigma, m/s^2.
    """
    F, Q = transition(seconds, acceleration)
    return Motion(motion.state @ F.T, F @ motion.covariance @ F.T + Q)


@lru_cache(maxsize=8)
def transition(seconds: float, acceleration: float) -> tuple[Array, Array]:
    """F and Q of one step, (6, 6) each."""
    place, rate = slice(0, 3), slice(3, 6)
    F, Q = np.eye(6), np.zeros((6, 6))
    variance = np.eye(3) * acceleration**2
    F[place, rate] = np.eye(3) * seconds
    Q[place, place], Q[rate, rate] = variance * (seconds**4 / 4), variance * seconds**2
    Q[place, rate] = Q[rate, place] = variance * (seconds**3 / 2)
    F.flags.writeable = Q.flags.writeable = False
    return F, Q


def manoeuvred(
    motion: Motion, target: Array, xyz: Array, noise: Array, seconds: float, bounces: Bounces
) -> Motion:
    """Predictions with larger covariances for targets that bounced or were hit, or whose tracks return.

    That is so if the innovation n exceeds the gate: n^T S^-1 n > gate^2.
    target: (M,) distinct; xyz: (M, 3) m; noise: (M, 3, 3) m^2; seconds: of the step.
    """
    innovation = xyz - motion.state[target, :3]
    place = motion.covariance[target, :3, :3]
    S = place + noise
    squared = (innovation[:, None] @ np.linalg.inv(S) @ innovation[..., None])[:, 0, 0]
    sudden = squared > bounces.gate * bounces.gate
    if not sudden.any():
        return motion
    covariance = motion.covariance.copy()
    covariance[target[sudden]] += sudden_covariance(
        innovation[sudden], squared[sudden], place[sudden], seconds, bounces
    )
    return Motion(motion.state, covariance)


def update(motion: Motion, target: Array, xyz: Array, noise: Array) -> tuple[Motion, Array]:
    """Correct some targets by measured positions: K = P H^T S^-1, with S = H P H^T + R.

    The covariance is (I - K H) P (I - K H)^T + K R K^T, and symmetric to the last bit: P - K H P is the same
    in exact arithmetic, but its rounding errors grow twofold with every step, until a variance is negative.
    target: (M,) distinct; xyz: (M, 3) m; noise: (M, 3, 3) m^2, R. Returns also n^T S^-1 n of the innovations
    n, (M,).
    """
    x, P = motion.state.take(target, axis=0), motion.covariance.take(target, axis=0)
    n = (xyz - x[:, :3])[..., None]
    S_inverse = np.linalg.inv(P[:, :3, :3] + noise)
    gain = (S_inverse @ P[:, :3]).swapaxes(1, 2)
    state, covariance = motion.state.copy(), motion.covariance.copy()
    state[target] = x + (gain @ n)[..., 0]
    reduced = P - gain @ P[:, :3]
    reduced -= (reduced[:, :, :3] - gain @ noise) @ gain.swapaxes(1, 2)
    covariance[target] = (reduced + reduced.swapaxes(1, 2)) / 2
    return Motion(state, covariance), (n * (S_inverse @ n)).sum(axis=(1, 2))


def followed(
    motion: Motion, target: Array, xyz: Array, noise: Array, sure: Array, seconds: float, bounces: Bounces
) -> Motion:
    """The motion corrected by measurements; improbable ones first enlarge the covariance.

    One that is not sure may be of something else. The motion is the mixture then of those with and without
    it, as in probabilistic data association (Bar-Shalom, Willett & Tian 2011, section 2.3.1).
    sure: (M,) bool; others as for :func:`manoeuvred`.
    """
    corrected, squared = update(motion, target, xyz, noise)
    sudden = squared > bounces.gate * bounces.gate
    if np.count_nonzero(sudden):
        wider = manoeuvred(motion, target[sudden], xyz[sudden], noise[sudden], seconds, bounces)
        corrected = update(wider, target, xyz, noise)[0]
    if np.count_nonzero(sure) == len(sure):
        return corrected
    unsure = (~sure).nonzero()[0]
    row, probability = target[unsure], association_probability(squared[unsure], bounces.gate)
    state, covariance = corrected
    state[row], covariance[row] = mixed(
        state[row], covariance[row], motion.state[row], motion.covariance[row], probability
    )
    return corrected


def slowed(motion: Motion, target: Array, factor: float) -> Motion:
    """The motion with the velocities of some targets multiplied, which may go on unslowed.

    target: (M,) distinct; factor: at most 1.
    """
    state, covariance = motion.state.copy(), motion.covariance.copy()
    covariance[target] += slowing_covariance(state[target], factor)
    state[target, 3:] *= factor
    return Motion(state, covariance)
