"""Manoeuvres of targets: accelerations, and bounces that change the velocity at once."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.stage_params import Field, StageParams


class ManoeuvreParams(StageParams):
    """How much targets manoeuvre."""

    acceleration_sigma: float = Field(
        12.0,
        gt=0,
        unit="m/s^2",
        description="sigma of the acceleration; raising it follows turns faster and smooths less",
    )
    bounce_gate: float = Field(
        3.0,
        gt=0,
        unit="sigma",
        description="distance from the forecast beyond which a target bounced; raising it smooths more",
    )
    initial_velocity_sigma: float = Field(
        3.0,
        gt=0,
        unit="m/s",
        description="sigma of a new target's velocity; raising it catches faster targets",
    )


def jump(seconds: float) -> Array:
    """Covariance (2, 2) of place and velocity after a jump of the velocity at any moment of the last step.

    Relative to that of the place: a jump w at s before the end moves it by s w, and s is uniform.
    """
    return np.array([[1.0, 1.5 / seconds], [1.5 / seconds, 3.0 / seconds**2]])


def bounce_covariance(innovation: Array, squared: Array, seconds: float) -> Array:
    """What a bounce adds to the covariance of position and velocity, (M, 6, 6), m and m/s.

    The velocity changed along the innovation n by an unknown amount at an unknown time of the last step: the
    covariance grows until n is one sigma. innovation: (M, 3) m; squared: (M,), n^T S^-1 n, above 1; seconds:
    of the step.
    """
    place = innovation[:, :, None] * innovation[:, None] * (1 - 1 / squared)[:, None, None]
    return np.kron(jump(seconds), place)


def slowing_covariance(state: Array, factor: float) -> Array:
    """What the covariance gains as motions are multiplied by a factor of at most 1, (M, D, D).

    A target that nothing shows may as well go on, so the second moment of its motion, P + w w^T, stays.
    state: (M, D), the place in m, then its derivatives w by time.
    """
    motion = np.array(state)
    motion[:, :3] = 0.0
    return np.asarray((1 - factor**2) * motion[:, :, None] * motion[:, None])
