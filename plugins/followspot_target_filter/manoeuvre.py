"""Manoeuvres of targets: accelerations, bounces that change the velocity at once, and tracks that return."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.stage_params import Field, StageParams


class Bounces(NamedTuple):
    """Bounces and hits of targets."""

    gate: float
    """Sigmas from the forecast beyond which a target bounced, or its track returns."""
    speed: float
    """Sigma of the change of velocity in a bounce, and of an unknown velocity, m/s."""


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
        description="largest distance between the forecast and a measurement without a bounce; raising it "
        "smooths more",
    )
    initial_velocity_sigma: float = Field(
        3.0,
        gt=0,
        unit="m/s",
        description="sigma of a new target's velocity, and of its change in a bounce; raising it catches "
        "faster targets",
    )

    @property
    def bounces(self) -> Bounces:
        """The bounces of targets."""
        return Bounces(self.bounce_gate, self.initial_velocity_sigma)


def jump(seconds: float) -> Array:
    """Covariance (2, 2) of place and velocity after a jump of the velocity at any moment of the last step.

    Relative to that of the place: a jump w at s before the end moves it by s w, and s is uniform.
    """
    return np.array([[1.0, 1.5 / seconds], [1.5 / seconds, 3.0 / seconds**2]])


def sudden_covariance(
    innovation: Array, squared: Array, place: Array, seconds: float, bounces: Bounces
) -> Array:
    """The increase of the covariance of position and velocity by a sudden innovation n: (M, 6, 6), m and m/s.

    It grows until n is one sigma. At a bounce the velocity changed along n by an unknown amount at an unknown
    time of the last step. Where the gate of the forecast is farther off than a bounce moves a target (root
    mean square), the track had left its target and returns: its velocity is as unknown as that of a new one.
    innovation: (M, 3) m; squared: (M,), n^T S^-1 n, above 1; place: (M, 3, 3) m^2, covariance of the
    forecast; seconds: of the step.
    """
    outer = innovation[:, :, None] * innovation[:, None]
    added = np.kron(jump(seconds), outer * (1 - 1 / squared)[:, None, None])
    along = (outer * place).sum(axis=(1, 2)) / np.vecdot(innovation, innovation)
    returned = bounces.gate**2 * along > bounces.speed**2 * seconds**2 / 3
    added[returned, 3:], added[returned, :, 3:] = 0.0, 0.0
    added[returned, 3:, 3:] = np.eye(3) * bounces.speed**2
    return added


def slowing_covariance(state: Array, factor: float) -> Array:
    """The increase of the covariance if motions are multiplied by a factor of at most 1, (M, D, D).

    A target without measurements may go on unslowed, so the second moment of its motion, P + w w^T, stays.
    state: (M, D), the place in m, then its derivatives w by time.
    """
    motion = np.array(state)
    motion[:, :3] = 0.0
    return np.asarray((1 - factor**2) * motion[:, :, None] * motion[:, None])
