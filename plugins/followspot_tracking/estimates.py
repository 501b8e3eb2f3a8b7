"""Estimates of S trackers of T targets as arrays, and their fusion by covariance intersection."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot.tracking import TRACKED, Tracks

SMALLEST_SIGMA = 1e-6
"""Lower limit of a sigma, m; one of 0 would make the estimate of any other tracker worthless."""


class Estimates(NamedTuple):
    """The estimate of each tracker for each target. Missing rows are zero, with a variance of 1."""

    there: Array
    """(S, T) bool."""
    measured: Array
    """(S, T) bool: tracked, and not merely predicted."""
    xyz: Array
    """(S, T, 3) m."""
    velocity: Array
    """(S, T, 3) m/s."""
    variance: Array
    """(S, T, 3) m^2."""


def of_room(tracks: Tracks, count: int) -> Array:
    """Rows whose target is one of the room's, (N,) bool; count: number of targets of the room."""
    return np.asarray((tracks.target >= 0) & (tracks.target < count))


def gathered(tracks: Sequence[Tracks], count: int) -> Estimates:
    """The rows of several messages; count: number of targets.

    Rows of other targets are left out, and so are those with unknown numbers, which would spoil the others.
    """
    shape = len(tracks), count
    there, measured = np.zeros(shape, bool), np.zeros(shape, bool)
    xyz, velocity = np.zeros((*shape, 3)), np.zeros((*shape, 3))
    variance = np.ones((*shape, 3))
    for row, message in enumerate(tracks):
        known = of_room(message, count) & _finite(message)
        target = message.target[known]
        there[row, target] = True
        measured[row, target] = message.state[known] == TRACKED
        xyz[row, target], velocity[row, target] = message.xyz[known], message.velocity[known]
        variance[row, target] = np.maximum(message.sigma[known], SMALLEST_SIGMA) ** 2
    return Estimates(there, measured, xyz, velocity, variance)


def _finite(tracks: Tracks) -> Array:
    """Rows of which all numbers are known, (N,) bool."""
    numbers = np.concatenate([tracks.xyz, tracks.velocity, tracks.sigma], axis=1)
    return np.asarray(np.isfinite(numbers).all(axis=1))


def confidence(estimates: Estimates) -> Array:
    """How far each estimate can be trusted, 1/m^2: (S, T), 0 if it is not there."""
    return np.where(estimates.there, 1.0 / estimates.variance.sum(axis=2), 0.0)


class Weights(NamedTuple):
    """Weights of the trackers for each target and axis, and the variance of the weighted mean."""

    share: Array
    """(S, T, 3); the sum over S is 1, or 0 for a target of which nothing is used."""
    variance: Array
    """(T, 3) m^2."""

    def mean(self, values: Array) -> Array:
        """The weighted mean of (S, T, 3) values: (T, 3)."""
        return np.asarray((self.share * values).sum(axis=0))


def intersection(estimates: Estimates, used: Array) -> Weights:
    """Covariance intersection of the estimates that are used, (S, T) bool.

    The errors of trackers of one object are correlated by its motion, and by cameras that they share, in an
    unknown way. Covariance intersection is consistent for any correlation (Julier & Uhlmann 1997);
    its exponents are proportional to 1 / trace (Niehsen 2002). Axes are independent, for tracks carry
    variances only.
    """
    trust = np.where(used, confidence(estimates), 0.0)
    exponent = trust / np.where(trust.sum(axis=0) > 0, trust.sum(axis=0), 1.0)
    information = exponent[..., None] / estimates.variance
    total = information.sum(axis=0)
    known = np.where(total > 0, total, 1.0)
    return Weights(information / known, 1.0 / known)
