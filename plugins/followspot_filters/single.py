"""A Kalman filter of filterpy for one target, with one model of motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from filterpy.kalman import KalmanFilter

from followspot import Array
from followspot_filters.bank import FIRST_ORDER
from followspot_filters.models import TransitionModel, transition
from followspot_target_filter.association_probability import association_probability, mixed
from followspot_target_filter.manoeuvre import Bounces, slowing_covariance, sudden_covariance


def filter_of(model: TransitionModel) -> KalmanFilter:
    """A filter of positions, with an empty state."""
    made = KalmanFilter(dim_x=model.size, dim_z=3)
    made.x, made.P = np.zeros(model.size), np.zeros((model.size, model.size))
    made.H = np.eye(3, model.size)
    return made


def widened(x: Array, P: Array, size: int, acceleration: float) -> tuple[Array, Array]:
    """A state and its covariance with an acceleration of zero, if they have none and the size has.

    acceleration: one sigma, m/s^2.
    """
    if len(x) == size:
        return x.copy(), P.copy()
    x_wide, P_wide = np.zeros(size), np.eye(size) * acceleration**2
    x_wide[: len(x)], P_wide[: len(x), : len(x)] = x, P
    return x_wide, P_wide


class SingleModel:
    """Filters one target.

    A measurement beyond the gate is a bounce, the return of the track to its target, or of another thing.

    initial_acceleration: one sigma of a new target's, m/s^2, if the model has accelerations.
    """

    def __init__(self, model: TransitionModel, bounces: Bounces, initial_acceleration: float) -> None:
        self.model = model
        self.bounces = bounces
        self.initial_acceleration = initial_acceleration
        self.filter = filter_of(model)

    @property
    def x(self) -> Array:
        return np.asarray(self.filter.x)

    @property
    def P(self) -> Array:  # noqa: N802
        return np.asarray(self.filter.P)

    def begin(self, x: Array, P: Array) -> None:
        self.filter.x, self.filter.P = widened(x, P, self.model.size, self.initial_acceleration)

    def predict(self, seconds: float) -> None:
        self.filter.predict(**transition(self.model, seconds)._asdict())

    def ahead(self, seconds: float) -> tuple[Array, Array]:
        F, Q = transition(self.model, seconds)
        return F @ self.x, F @ self.P @ F.T + Q

    def update(self, xyz: Array, noise: Array, sure: bool, seconds: float) -> None:
        offset = xyz - self.x[:3]
        squared = np.array([offset @ np.linalg.solve(self.P[:3, :3] + noise, offset)])
        x, P = self.x, self.P
        if squared[0] > self.bounces.gate**2:
            grown = sudden_covariance(offset[None], squared, P[None, :3, :3], seconds, self.bounces)
            wider = P.copy()
            wider[:FIRST_ORDER, :FIRST_ORDER] += grown[0]
            self.filter.P = wider
        self.filter.update(xyz, R=noise)
        self.filter.P = (self.P + self.P.T) / 2
        if not sure:
            probability = association_probability(squared, self.bounces.gate)
            mixture = mixed(self.x[None], self.P[None], x[None], P[None], probability)
            self.filter.x, self.filter.P = (part[0] for part in mixture)

    def slow(self, factor: float) -> None:
        self.filter.P = self.P + slowing_covariance(self.x[None], factor)[0]
        self.filter.x = np.concatenate([self.x[:3], self.x[3:] * factor])

    def stop(self, xyz: Array) -> None:
        self.filter.x = np.concatenate([xyz, np.zeros(self.model.size - 3)])

    def parts(self) -> Sequence[Array]:
        return self.x, self.P

    def restore(self, parts: Sequence[Array]) -> None:
        self.filter.x, self.filter.P = parts
