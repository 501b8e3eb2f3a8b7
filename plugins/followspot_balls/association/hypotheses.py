"""Hypotheses of where targets are: as forecast or at a candidate, each moved to its likeliest place.

A pair of half covered blobs is triangulated badly, so a candidate only tells where to begin. From there
Gauss-Newton steps lead to the place that its prior and the likeliest blobs of all views make most likely.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import Forecast
from followspot_balls.association.likelihood import information


class MotionPrior(NamedTuple):
    """How a target moves from frame to frame: as forecast, or it jumps, as it is thrown, hit or mistaken."""

    added: float
    """m, sigma that adds to the forecast's if the target moves as forecast."""
    jump: float
    """m, likewise if it jumps."""
    jump_probability: float
    """Probability of a jump."""
    reach: float
    """m, sigma of the place of a target without forecast around its candidate."""


class Hypotheses(NamedTuple):
    """M places of targets, and what was known of each before the views: a Gaussian with a probability."""

    xyz: Array
    """(M, 3) m."""
    target: Array
    """(M,)."""
    row: Array
    """(M,) the candidate that it began at, -1 for the forecast."""
    mean: Array
    """(M, 3) m."""
    variance: Array
    """(M,) m^2, along each axis."""
    weight: Array
    """(M,) logarithm of its probability."""

    def moved(self, xyz: Array) -> Hypotheses:
        """The same hypotheses at other places (M, 3) m."""
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
    begun = xyz[row]
    count = len(row)
    nothing = np.zeros(count)
    found = Hypotheses(begun, target, row, begun, np.full(count, prior.reach**2), nothing)
    if forecast is None or not tracked.any():
        return found
    spread = forecast.covariance.diagonal(axis1=1, axis2=2).mean(axis=1)
    known = tracked[target]
    jumps = found._replace(
        mean=np.where(known[:, None], forecast.xyz[target], begun),
        variance=np.where(known, spread[target] + prior.jump**2, found.variance),
        weight=np.where(known, np.log(prior.jump_probability), 0.0),
    )
    expected = np.unique(target[known])
    place = forecast.xyz[expected]
    steady = Hypotheses(
        place,
        expected,
        np.full(len(expected), -1),
        place,
        spread[expected] + prior.added**2,
        np.full(len(expected), np.log1p(-prior.jump_probability)),
    )
    return Hypotheses(*map(np.concatenate, zip(jumps, steady, strict=True)))


def jacobians(P: Array, xy: Array, depth: Array) -> Array:
    """Derivatives of images by places: (C, 3, 4), (M, C, 2) px, (M, C) m -> (M, C, 2, 3) px/m."""
    return np.asarray((P[:, :2, :3] - xy[..., None] * P[:, 2:, :3]) / depth[..., None, None])


def step(found: Hypotheses, jacobian: Array, error: Array, weight: Array) -> Array:
    """The Gauss-Newton step of M places to their maximum a posteriori, (M, 3) m.

    jacobian: (M, C, 2, 3) px/m; error: (M, C, 2) px, of the likeliest blobs from the images; weight: (M, C)
    1/px^2, of :func:`followspot_balls.association.likelihood.precision`.
    """
    variance = found.variance[:, None]
    normal = information(jacobian, weight).sum(axis=1) + np.eye(3) / variance[..., None]
    right = np.einsum("mcik,mci->mk", jacobian, weight[..., None] * error)
    right += (found.mean - found.xyz) / variance
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])
