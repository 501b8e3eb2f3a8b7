"""An interacting multiple model of filterpy for one target (Blom & Bar-Shalom 1988)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from filterpy.kalman import IMMEstimator

from followspot import Array
from followspot_filters.models import TransitionModel, transition
from followspot_filters.single import filter_of, widened

SWITCHING = np.array([[0.94, 0.05, 0.01], [0.05, 0.94, 0.01], [0.45, 0.45, 0.10]])
"""Probability that a target goes from the model of the row to that of the column in a step.

In this order: constant velocity, constant acceleration, bounce. A toss lasts about 20 steps; after a bounce
either of the others follows.
"""
AT_FIRST = np.array([0.5, 0.4, 0.1])
"""Probabilities of the models for a new target."""


class InteractingModels:
    """Follows one target by three models; the measurements tell which one describes it.

    models: constant velocity, constant acceleration and bounce, of equal size; initial_acceleration: one
    sigma of a new target's, m/s^2. Whether a measurement is sure is not asked.
    """

    def __init__(self, models: Sequence[TransitionModel], initial_acceleration: float) -> None:
        self.models = models
        self.initial_acceleration = initial_acceleration
        self.mixture = IMMEstimator([filter_of(model) for model in models], AT_FIRST, SWITCHING)

    @property
    def x(self) -> Array:
        return np.asarray(self.mixture.x)

    @property
    def P(self) -> Array:  # noqa: N802
        return np.asarray(self.mixture.P)

    def begin(self, x: Array, P: Array) -> None:
        x, P = widened(x, P, self.models[0].size, self.initial_acceleration)
        count = len(self.models)
        self._put(np.stack([x] * count), np.stack([P] * count), AT_FIRST)

    def predict(self, seconds: float) -> None:
        for one, model in zip(self.mixture.filters, self.models, strict=True):
            one.F, one.Q = transition(model, seconds)
        self.mixture.predict()

    def ahead(self, seconds: float) -> tuple[Array, Array]:
        now = self.parts()
        self.predict(seconds)
        found = self.x.copy(), self.P.copy()
        self.restore(now)
        return found

    def update(self, xyz: Array, noise: Array, sure: bool, seconds: float) -> None:
        for one in self.mixture.filters:
            one.R = noise
        self.mixture.update(xyz)

    def slow(self, factor: float) -> None:
        xs, Ps, probability = self.parts()
        self._put(np.hstack([xs[:, :3], xs[:, 3:] * factor]), Ps, probability)

    def stop(self, xyz: Array) -> None:
        xs, Ps, probability = self.parts()
        self._put(np.hstack([np.tile(xyz, (len(xs), 1)), np.zeros_like(xs[:, 3:])]), Ps, probability)

    def parts(self) -> tuple[Array, Array, Array]:
        """States (K, D) and covariances (K, D, D) of the models, and their probabilities (K,)."""
        filters = self.mixture.filters
        return np.array([one.x for one in filters]), np.array([one.P for one in filters]), self.mixture.mu

    def restore(self, parts: Sequence[Array]) -> None:
        self._put(*parts)

    def _put(self, xs: Array, Ps: Array, probability: Array) -> None:
        """Set the state and covariance of each model, and the probabilities of the models.

        The mixture is made again, because its constructor computes the mixing probabilities.
        """
        for one, x, P in zip(self.mixture.filters, xs, Ps, strict=True):
            one.x, one.P = x.copy(), P.copy()
        self.mixture = IMMEstimator(self.mixture.filters, probability, SWITCHING)
