"""One filter of the package filterpy for each target, as a motion model of `followspot_target_filter`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np

from followspot import Array
from followspot_target_filter.motion_model import Estimate

FIRST_ORDER = 6
"""Numbers of position and velocity, with which every state begins."""


class TargetEstimator(Protocol):
    """Filters one target. The state is position, velocity and more: x (D,), P (D, D)."""

    @property
    def x(self) -> Array:
        """State."""

    @property
    def P(self) -> Array:  # noqa: N802
        """Its covariance."""

    def begin(self, x: Array, P: Array) -> None:
        """Begin anew. x, P: of position and velocity alone (6), or of the whole state."""

    def predict(self, seconds: float) -> None:
        """Move on by a step."""

    def ahead(self, seconds: float) -> tuple[Array, Array]:
        """State and covariance one step later; nothing changes."""

    def update(self, xyz: Array, noise: Array, sure: bool, seconds: float) -> None:
        """Correct by a measured position: (3,) m, (3, 3) m^2."""

    def slow(self, factor: float) -> None:
        """Multiply the velocity, and what changes it."""

    def stop(self, xyz: Array) -> None:
        """Come to rest at a place."""

    def parts(self) -> Sequence[Array]:
        """Checkpoint: arrays of fixed shapes."""

    def restore(self, parts: Sequence[Array]) -> None:
        """Carry on from a checkpoint."""


class Bank:
    """A motion model of T targets, one estimator each.

    make: an estimator before any measurement; kind: name of the model in checkpoints; initial_speed: one
    sigma of a new target's velocity, m/s.
    """

    def __init__(
        self, count: int, make: Callable[[], TargetEstimator], kind: str, initial_speed: float
    ) -> None:
        self.kind = kind
        self.initial_speed = initial_speed
        self.estimators = [make() for _ in range(count)]

    @property
    def estimate(self) -> Estimate:
        return _estimate([(one.x, one.P) for one in self.estimators])

    def predict(self, seconds: float) -> None:
        for one in self.estimators:
            one.predict(seconds)

    def ahead(self, seconds: float) -> Estimate:
        return _estimate([one.ahead(seconds) for one in self.estimators])

    def initiate(self, target: Array, xyz: Array, noise: Array) -> None:
        for number, place, R in zip(target, xyz, noise, strict=True):
            P = np.zeros((FIRST_ORDER, FIRST_ORDER))
            P[:3, :3], P[3:, 3:] = R, np.eye(3) * self.initial_speed**2
            self.estimators[number].begin(np.concatenate([place, np.zeros(3)]), P)

    def update(self, target: Array, xyz: Array, noise: Array, sure: Array, seconds: float) -> None:
        for number, place, R, certain in zip(target, xyz, noise, sure, strict=True):
            self.estimators[number].update(place, R, bool(certain), seconds)

    def slow(self, target: Array, factor: float) -> None:
        for number in target:
            self.estimators[number].slow(factor)

    def stop(self, target: Array, xyz: Array) -> None:
        for number, place in zip(target, xyz, strict=True):
            self.estimators[number].stop(place)

    def state(self) -> Mapping[str, Array]:
        first = slice(FIRST_ORDER)
        state = np.array([one.x[first] for one in self.estimators]).reshape(-1, FIRST_ORDER)
        covariance = [one.P[first, first] for one in self.estimators]
        kept = {"state": state, "covariance": np.reshape(covariance, (-1, FIRST_ORDER, FIRST_ORDER))}
        parts = zip(*[one.parts() for one in self.estimators], strict=True)
        return kept | {f"{self.kind}.{n}": np.array(part) for n, part in enumerate(parts)}

    def restore(self, state: Mapping[str, Array]) -> None:
        own = [state[key] for key in sorted(key for key in state if key.startswith(f"{self.kind}."))]
        for number, one in enumerate(self.estimators):
            if own:
                one.restore([np.array(part[number]) for part in own])
            else:
                one.begin(np.array(state["state"][number]), np.array(state["covariance"][number]))


def _estimate(found: Sequence[tuple[Array, Array]]) -> Estimate:
    x = np.array([state[:FIRST_ORDER] for state, _ in found]).reshape(-1, FIRST_ORDER)
    P = np.array([covariance[:3, :3] for _, covariance in found]).reshape(-1, 3, 3)
    return Estimate(x[:, :3], x[:, 3:], P)
