"""Transitions of first- and second-order motion, for the filters of the package filterpy.

The state is position, velocity and, if it has nine numbers, acceleration: m, m/s, m/s^2.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, NamedTuple

import numpy as np

from followspot import Array


class Transition(NamedTuple):
    """x' = F x, P' = F P F^T + Q, each (D, D)."""

    F: Array
    Q: Array


@dataclass(frozen=True)
class TransitionModel(ABC):
    """A model of motion: it can be hashed, so that transitions are computed once for each interval."""

    size: ClassVar[int]
    """D, numbers of the state."""

    @abstractmethod
    def noise(self, seconds: float) -> Array:
        """Q of a step for one axis, (D/3, D/3)."""


@dataclass(frozen=True)
class ConstantVelocity(TransitionModel):
    """Acceleration that is constant during a step and independent of that of other steps.

    acceleration: one sigma, m/s^2.
    """

    acceleration: float
    size = 6

    def noise(self, seconds: float) -> Array:
        """Position and velocity after the acceleration of a step."""
        return _outer(seconds**2 / 2, seconds) * self.acceleration**2


@dataclass(frozen=True)
class ConstantAcceleration(TransitionModel):
    """Jerk that is constant during a step and independent of that of other steps.

    jerk: one sigma, m/s^3.
    """

    jerk: float
    size = 9

    def noise(self, seconds: float) -> Array:
        """Position, velocity and acceleration after the jerk of a step."""
        return _outer(seconds**3 / 6, seconds**2 / 2, seconds) * self.jerk**2


@dataclass(frozen=True)
class Forgetful(TransitionModel):
    """A first-order model in a state with acceleration, which is forgotten in every step.

    model: of position and velocity; acceleration: one sigma of the next step's, m/s^2; bounce: one sigma of a
    change of velocity at any moment of the step, m/s.
    """

    model: ConstantVelocity
    acceleration: float
    bounce: float = 0.0
    size = 9

    def noise(self, seconds: float) -> Array:
        """Process noise of the model, of the bounce, and of an unknown acceleration, (3, 3)."""
        Q = np.zeros((3, 3))
        Q[:2, :2] = self.model.noise(seconds)
        Q[:2, :2] += np.array([[seconds**2 / 3, seconds / 2], [seconds / 2, 1.0]]) * self.bounce**2
        Q[2, 2] = self.acceleration**2
        return Q


@lru_cache(maxsize=32)
def transition(model: TransitionModel, seconds: float) -> Transition:
    """The transition of a step along all three axes."""
    powers = (1.0, seconds, seconds**2 / 2)
    F = np.eye(model.size // 3)
    for row, column in np.argwhere(np.triu(np.ones_like(F), 1)):
        F[row, column] = powers[column - row]
    if isinstance(model, Forgetful):
        F[:, 2] = 0.0
    return Transition(np.kron(F, np.eye(3)), np.kron(model.noise(seconds), np.eye(3)))


def _outer(*gain: float) -> Array:
    """Covariance of numbers that one random number moves by these gains."""
    column: Sequence[float] = gain
    return np.outer(column, column)
