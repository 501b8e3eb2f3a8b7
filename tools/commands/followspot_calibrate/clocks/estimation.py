"""Clock offsets from motion: one adjustment of places and offsets, in which the places are eliminated.

A target moves with v through X; camera c saw it later, by l by its time stamp and by o by its clock, so at
P_c(X + v (l + o)). With J the derivative of that image by the place, every sighting x says

    x - P_c(X + v (l + o0)) = J dX + (J v) (o - o0).

All offsets at once, because what one camera is late draws the place, too. Sightings that fit badly weigh less
(Cauchy). An offset that all share only moves X along its path and cannot be seen.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_calibrate.clocks.moments import Moments, velocities

PASSES = 3
"""Rounds of velocities from places, and places from velocities."""
STEPS = 10
"""Rounds of reweighted least squares."""
CUTOFF = 2.0
"""Median errors at which a sighting keeps half its weight."""
MOVING = 30.0
"""Image speed from which a sighting has information on clocks, px/s: 0.03 px a millisecond."""
STRETCH = 1.0
"""Errors within that time are taken as one, for a ball stays hidden for a while, s."""
VAGUE = 1e-3
"""Information that is there without any view, on places and offsets: keeps equations solvable."""


@dataclass(frozen=True, eq=False)
class Offsets:
    """Clock offsets of C cameras, relative to their mean.

    offset: (C,) s; covariance: (C, C) s^2; sightings: (C,) of moving targets, that were believed.
    """

    offset: Array
    covariance: Array
    sightings: Array

    @property
    def sigma(self) -> Array:
        """(C,) s."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance)))

    def relative_to(self, camera: int) -> Offsets:
        """The offsets, with that of one camera as zero."""
        change = np.eye(len(self.offset))
        change[:, camera] -= 1.0
        return replace(self, offset=change @ self.offset, covariance=change @ self.covariance @ change.T)


class Linear(NamedTuple):
    """Sightings of N moments by C cameras, linearised; zero if there is none."""

    J: Array
    """(N, C, 2, 3) px/m."""
    motion: Array
    """(N, C, 2) px/s: J v."""
    error: Array
    """(N, C, 2) px."""
    seen: Array
    """(N, C) bool."""


class Reduced(NamedTuple):
    """Normal equations of the offsets, the places eliminated (H&Z, appendix A6.3.1)."""

    normal: Array
    """(C, C)."""
    score: Array
    """(N, C): the right side, moment by moment."""
    step: Array
    """(N, 3) m: of the places, if the offsets stay."""


def estimated(found: Moments, P: Array, start: Array) -> Offsets:
    """Offsets of C > 1 cameras from N moments. P: (C, 3, 4); start: (C,) s, near which they are sought."""
    offset, xyz = start - start.mean(), found.xyz
    for _ in range(PASSES):
        now = replace(found, xyz=xyz)
        linear = linearised(now, P, velocities(found.time, found.target, xyz), offset)
        weight = linear.seen.astype(float)
        for _ in range(STEPS):
            change, left = solved(linear, weight)
            weight = cauchy(residuals(left, weight), linear.seen)
        offset, xyz = offset + change, xyz + reduced(left, weight).step
    fast = linear.seen & (np.hypot(*np.moveaxis(linear.motion, 2, 0)) >= MOVING) & (weight > 0.5)
    return Offsets(offset, covariance(left, weight, stretches(found)), fast.sum(axis=0))


def linearised(found: Moments, P: Array, velocity: Array, offset: Array) -> Linear:
    """Errors and derivatives at these velocities (N, 3) m/s and offsets (C,) s.

    Moments without a velocity, and those of one camera alone, have no information.
    """
    place = found.xyz[:, None] + velocity[:, None] * (found.late + offset)[..., None]
    image = np.einsum("cij,ncj->nci", P[:, :, :3], place) + P[:, :, 3]
    depth = np.where(image[..., 2] > 0, image[..., 2], np.nan)
    xy = image[..., :2] / depth[..., None]
    J = (P[:, :2, :3] - xy[..., None] * P[:, 2:, :3]) / depth[..., None, None]
    error = found.xy - xy
    seen = np.isfinite(error).all(axis=2)
    seen &= seen.sum(axis=1, keepdims=True) > 1
    J, error = np.where(seen[..., None, None], J, 0.0), np.where(seen[..., None], error, 0.0)
    return Linear(J, np.einsum("ncij,nj->nci", J, np.nan_to_num(velocity)), error, seen)


def reduced(linear: Linear, weight: Array) -> Reduced:
    """The equations of the offsets, for weights (N, C)."""
    J, motion, error, _ = linear
    JW = J * weight[..., None, None]
    places = np.einsum("ncij,ncik->njk", JW, J) + VAGUE * np.eye(3)
    step = np.linalg.solve(places, np.einsum("ncij,nci->nj", JW, error)[..., None])[..., 0]
    mixed = np.einsum("ncij,nci->ncj", JW, motion)
    eliminated = np.linalg.solve(places, mixed.swapaxes(1, 2))
    own = (weight * np.square(motion).sum(axis=2)).sum(axis=0)
    normal = np.diag(own) - np.einsum("ncj,njd->cd", mixed, eliminated)
    score = weight * (motion * error).sum(axis=2) - np.einsum("ncj,nj->nc", mixed, step)
    return Reduced(normal, score, step)


def solved(linear: Linear, weight: Array) -> tuple[Array, Linear]:
    """The change of the offsets (C,) s, of zero mean, and the equations after it."""
    system = reduced(linear, weight)
    change = inverse(system.normal) @ system.score.sum(axis=0)
    return change, linear._replace(error=linear.error - linear.motion * change[:, None])


def inverse(normal: Array) -> Array:
    """Inverse of the normal matrix (C, C) for offsets with zero mean; only differences are observable."""
    mean = np.full_like(normal, 1 / len(normal))
    scale = max(np.trace(normal) / len(normal), VAGUE)
    within = np.eye(len(normal)) - mean
    return np.asarray(within @ np.linalg.inv(normal + VAGUE * np.eye(len(normal)) + scale * mean) @ within)


def residuals(linear: Linear, weight: Array) -> Array:
    """Remaining errors when the places follow the views: (N, C, 2) px."""
    return np.asarray(linear.error - np.einsum("ncij,nj->nci", linear.J, reduced(linear, weight).step))


def cauchy(residual: Array, seen: Array) -> Array:
    """Weights (N, C) of residuals (N, C, 2) px, relative to their median."""
    square = np.square(residual).sum(axis=2)
    scale = CUTOFF**2 * np.median(square[seen]) if seen.any() else 1.0
    return np.asarray(seen / (1 + square / max(scale, VAGUE)))


def covariance(linear: Linear, weight: Array, stretch: Array) -> Array:
    """Covariance of the offsets, (C, C) s^2: from the scatter over stretches, at least that of white noise.

    stretch: (N,) numbers, from 0. Errors within a stretch depend on each other, hence the sandwich form.
    """
    normal, score, _ = reduced(linear, weight)
    bread, count = inverse(normal), len(normal)
    sums = np.zeros((int(stretch.max(initial=-1)) + 1, count))
    np.add.at(sums, stretch, score)
    sandwich = bread @ sums.T @ sums @ bread
    left = (weight * np.square(residuals(linear, weight)).sum(axis=2)).sum()
    freedom = 2 * linear.seen.sum() - 3 * linear.seen.any(axis=1).sum() - count + 1
    white = bread * left / max(freedom, 1)
    return np.asarray(sandwich if np.trace(sandwich) > np.trace(white) else white)


def stretches(found: Moments) -> Array:
    """Which stretch of time of which target each moment is in: (N,) numbers from 0."""
    second = np.floor(found.time / STRETCH)
    return np.unique(np.column_stack([found.target, second]), axis=0, return_inverse=True)[1].ravel()
