"""The interface of motion models, so that a filter of targets can swap them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from followspot.messages import Array


class Estimate(NamedTuple):
    """Positions and velocities of T targets, with the covariances of the positions."""

    xyz: Array
    """(T, 3) m."""
    velocity: Array
    """(T, 3) m/s."""
    covariance: Array
    """(T, 3, 3) m^2, of the positions."""

    @property
    def sigma(self) -> Array:
        """(T, 3) m, of the position along each axis."""
        return np.asarray(np.sqrt(self.covariance.diagonal(axis1=1, axis2=2)))


class MotionModel(Protocol):
    """The motion of T targets as a filter estimates it, frame by frame.

    In each frame the filter calls `predict`, `initiate` for targets that are found anew, `update` for the
    other measured ones, and then `slow` or `stop` for coasting ones. target: (M,) distinct numbers; xyz:
    (M, 3) m; noise: (M, 3, 3) m^2, covariance of the measured positions.
    """

    @property
    def estimate(self) -> Estimate:
        """The targets now; the rows of targets that were never initiated have no meaning."""

    def predict(self, seconds: float) -> None:
        """Move all targets on by a step."""

    def ahead(self, seconds: float) -> Estimate:
        """The targets one step later; nothing changes."""

    def initiate(self, target: Array, xyz: Array, noise: Array) -> None:
        """Begin some targets anew: at rest where they were measured."""

    def update(self, target: Array, xyz: Array, noise: Array, sure: Array, seconds: float) -> None:
        """Correct some targets by measured positions.

        sure: (M,) bool, positions that are surely of their targets, while others may be of something else;
        seconds: of the last step.
        """

    def slow(self, target: Array, factor: float) -> None:
        """Multiply the velocity of some targets; the covariance grows, for they may go on unslowed."""

    def stop(self, target: Array, xyz: Array) -> None:
        """Put some targets to rest at places."""

    def state(self) -> Mapping[str, Array]:
        """Checkpoint: at least `state` (T, 6), position and velocity, and `covariance` (T, 6, 6) of these.

        Any model can begin from these two, so that one can take the place of another in a run.
        """

    def restore(self, state: Mapping[str, Array]) -> None:
        """Carry on from a checkpoint of this model or another one."""
