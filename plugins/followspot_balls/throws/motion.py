"""Constant-acceleration Kalman filters of many paths in one picture, and which blob continues which path.

Axes u and v are alike and independent: a path has one covariance (3, 3) over position, velocity and
acceleration for both, and its state is (3, 2).
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from followspot import Array


class Paths(NamedTuple):
    """Open paths, one row each."""

    number: Array
    """(K,) never used twice."""
    target: Array
    """(K,) target of the blobs."""
    state: Array
    """(K, 3, 2) position px, velocity px/s, acceleration px/s^2."""
    covariance: Array
    """(K, 3, 3)."""
    missed: Array
    """(K,) frames since the last blob."""

    def take(self, rows: Array) -> Self:
        """The paths that a mask (K,) or row numbers select."""
        return type(self)(*(column[rows] for column in self))

    def and_also(self, others: Paths) -> Self:
        """These paths followed by the others."""
        return type(self)(*(np.concatenate(pair) for pair in zip(self, others, strict=True)))


def initiated(first: int, target: Array, xy: Array, sigma: tuple[float, float, float]) -> Paths:
    """New paths of one blob each, initially at rest.

    first: number of the first path; target: (N,); xy: (N, 2) px; sigma: of position px, velocity px/s and
    acceleration px/s^2.
    """
    count = len(target)
    state = np.zeros((count, 3, 2))
    state[:, 0] = xy
    covariance = np.broadcast_to(np.diag(np.square(sigma)), (count, 3, 3))
    return Paths(first + np.arange(count), target, state, covariance, np.zeros(count, int))


def predicted(paths: Paths, period: float, jerk: float) -> Paths:
    """The paths after a period (s) of white jerk with density jerk^2 (px/s^2 after one second)."""
    t = period
    F = np.array([[1, t, t**2 / 2], [0, 1, t], [0, 0, 1]])
    Q = np.array([[t**5 / 20, t**4 / 8, t**3 / 6], [t**4 / 8, t**3 / 3, t**2 / 2], [t**3 / 6, t**2 / 2, t]])
    covariance = F @ paths.covariance @ F.T + jerk**2 * Q
    return paths._replace(state=F @ paths.state, covariance=covariance, missed=paths.missed + 1)


def assigned(paths: Paths, target: Array, xy: Array, noise: float, gate: float) -> tuple[Array, Array]:
    """Pairs of path and blob, the likeliest first, none used twice: rows of paths, rows of blobs.

    target: (N,); xy: (N, 2) px; noise: sigma of a blob, px; gate: largest distance in sigmas.
    """
    variance = (paths.covariance[:, 0, 0] + noise**2)[:, None]
    offset = xy[None] - paths.state[:, None, 0]
    distance = np.square(offset).sum(axis=2) / variance
    likely = (distance < gate**2) & (paths.target[:, None] == target)
    row, blob = np.nonzero(likely)
    order = np.argsort((distance + 2 * np.log(variance))[row, blob], kind="stable")
    free_path, free_blob = np.ones(len(paths.number), bool), np.ones(len(target), bool)
    chosen = []
    for pair in order.tolist():
        if free_path[row[pair]] and free_blob[blob[pair]]:
            free_path[row[pair]] = free_blob[blob[pair]] = False
            chosen.append(pair)
    return row[chosen], blob[chosen]


def updated(paths: Paths, rows: Array, xy: Array, noise: float) -> Paths:
    """The paths updated by blobs: rows (M,) measured at xy (M, 2) px; noise: sigma of a blob, px."""
    covariance = paths.covariance[rows]
    gain = covariance[:, :, 0] / (covariance[:, :1, 0] + noise**2)
    innovation = xy - paths.state[rows, 0]
    after = Paths(*(column.copy() for column in paths))
    after.state[rows] += gain[:, :, None] * innovation[:, None]
    after.covariance[rows] -= gain[:, :, None] * covariance[:, :1]
    after.missed[rows] = 0
    return after
