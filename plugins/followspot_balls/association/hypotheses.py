"""Hypotheses of positions of targets: as forecast or at a candidate, each moved to its likeliest position.

A pair of half covered blobs is triangulated badly, so a candidate is only the initial estimate. Gauss-Newton
steps lead from it to the position that its prior and the likeliest blobs of all views make most likely.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import Forecast
from followspot_balls.association.likelihood import information


class MotionPrior(NamedTuple):
    """Motion of a target from frame to frame: as forecast, or it jumps when it is thrown, hit or mistaken."""

    added: float
    """m, sigma that adds to the forecast's if the target moves as forecast."""
    jump: float
    """m, likewise if it jumps."""
    jump_probability: float
    """Probability of a jump."""
    reach: float
    """m, sigma of the position of a target without forecast around its candidate."""


class Hypotheses(NamedTuple):
    """M positions of targets, and what was known of each before the views: a Gaussian with a probability."""

    xyz: Array
    """(M, 3) m."""
    target: Array
    """(M,)."""
    row: Array
    """(M,) the candidate of the initial estimate, -1 for the forecast."""
    mean: Array
    """(M, 3) m."""
    variance: Array
    """(M,) m^2, along each axis."""
    weight: Array
    """(M,) logarithm of its probability."""

    def moved(self, xyz: Array) -> Hypotheses:
        """The same hypotheses at other positions (M, 3) m."""
        return self._replace(xyz=xyz)

    def improbability(self) -> Array:
        """Half the squared distances from the means, in sigmas, minus the weights: (M,)."""
        off = self.xyz - self.mean
        return np.asarray(np.vecdot(off, off) / (2 * self.variance) - self.weight)


def hypotheses(
    xyz: Array, row: Array, target: Array, forecast: Forecast | None, tracked: Array, prior: MotionPrior
) -> Hypotheses:
    """The hypotheses of candidates (N, 3) m: of some rows as some targets, (M,) each, and of the forecasts.

    A tracked target, (T,) bool, with candidates moves as forecast, or it jumps to one of them.
    """
    initial = xyz[row]
    count = len(row)
    nothing = np.zeros(count)
    found = Hypotheses(initial, target, row, initial, np.full(count, prior.reach**2), nothing)
    if forecast is None or not tracked.any():
        return found
    spread = forecast.covariance.diagonal(axis1=1, axis2=2).mean(axis=1)
    known = tracked[target]
    jumps = found._replace(
        mean=np.where(known[:, None], forecast.xyz[target], initial),
        variance=np.where(known, spread[target] + prior.jump**2, found.variance),
        weight=np.where(known, np.log(prior.jump_probability), 0.0),
    )
    expected = np.unique(target[known])
    predicted = forecast.xyz[expected]
    steady = Hypotheses(
        predicted,
        expected,
        np.full(len(expected), -1),
        predicted,
        spread[expected] + prior.added**2,
        np.full(len(expected), np.log1p(-prior.jump_probability)),
    )
    return Hypotheses(*map(np.concatenate, zip(jumps, steady, strict=True)))


def jacobians(P: Array, xy: Array, depth: Array) -> Array:
    """Derivatives of projections by positions: (C, 3, 4), (M, C, 2) px, (M, C) m -> (M, C, 2, 3) px/m."""
    return np.asarray((P[:, :2, :3] - xy[..., None] * P[:, 2:, :3]) / depth[..., None, None])


def gauss_newton_step(found: Hypotheses, jacobian: Array, residual: Array, weight: Array) -> Array:
    """The Gauss-Newton step of M positions to their maximum a posteriori, (M, 3) m.

    jacobian: (M, C, 2, 3) px/m; residual: (M, C, 2) px, likeliest blobs minus projections; weight: (M, C)
    1/px^2, of :func:`followspot_balls.association.likelihood.precision`.
    """
    variance = found.variance[:, None]
    normal = information(jacobian, weight).sum(axis=1) + np.eye(3) / variance[..., None]
    right = np.einsum("mcik,mci->mk", jacobian, weight[..., None] * residual)
    right += (found.mean - found.xyz) / variance
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])
