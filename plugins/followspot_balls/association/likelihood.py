"""Likelihood ratio of a ball against clutter, from the blobs of all views.

The image of a ball is a disc of known radius, of which people may cover a part. Clutter is a Poisson process
of blobs (Bar-Shalom, Daum & Huang 2009, the probabilistic data association filter).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.measurement.center_precision import WHOLE

MINIMUM_CLUTTER_RATIO = 0.02
"""Smallest density of clutter over the usual one: clutter may appear where a view has never shown any."""


class BallModel(NamedTuple):
    """How views detect balls, and how dense clutter is."""

    detection: float
    """Probability that a view detects a ball that is there; people cover it often."""
    clutter: float
    """Usual density of clutter, blobs in a square whose side is the ball's radius."""
    neighbourhood: float
    """Radius around a ball's image in which other blobs count as clutter, over the radius of the image."""
    sigma: float
    """Sigma of the centre of a whole ball, px."""
    relative_sigma: float
    """Sigma that adds to it, over the radius of the ball's image."""
    hidden_sigma: float
    """Sigma that adds to it if the outline is completely hidden, over the radius of the ball's image."""
    minimum_radius: Array | float = 0.0
    """(C,) radius of a ball's image below which clutter is no denser, px."""


class BlobResiduals(NamedTuple):
    """K blobs of C views compared with the projections of M hypotheses, each a position of a target."""

    squared_distance: Array
    """(M, C, K) px^2, of the blobs from the projection of the position."""
    area_ratio: Array
    """(M, C, K) area of the blobs over that of the target's outline."""
    radius: Array
    """(M, C) radius of the target's image, px."""
    compatible: Array
    """(M, C, K) bool, whether the blob may show the target."""
    in_picture: Array
    """(M, C) bool, whether the position has an image in the picture."""
    clutter_ratio: Array
    """(C, K) density of clutter around each blob over the usual one."""


class LikeliestBlobs(NamedTuple):
    """The likeliest blob of each view."""

    slot: Array
    """(M, C)."""
    ratio: Array
    """(M, C) its density if it is the ball, over its density if it is anything else."""
    variance: Array
    """(M, C) of its distance from the projection, px^2."""


def ball_densities(
    model: BallModel, residuals: BlobResiduals, spread: Array | float = 0.0
) -> tuple[Array, Array]:
    """Densities of blobs, 1/px^2, if balls are at the positions, and variances of their centres: (M, C, K).

    If a disc is partly covered, or its blob is merged with other light, the centre of the blob is off by a
    part of the radius. Clutter of all sizes up to the ball's is equally likely, but large visible parts of a
    ball are likelier than small ones: a fragment is poor evidence.
    spread: variance of the projection of the position, px^2. The variances are in px^2.
    """
    size, area_ratio = residuals.radius[..., None], residuals.area_ratio
    off = model.hidden_sigma * np.maximum(1.0 - area_ratio, 0.0) + np.maximum(area_ratio - WHOLE, 0.0)
    variance = model.sigma**2 + (np.square(model.relative_sigma) + np.square(off)) * np.square(size) + spread
    size_ratio = 2.0 * np.minimum(area_ratio, 1.0) * residuals.compatible
    exponent = -0.5 * residuals.squared_distance / variance
    return np.asarray(size_ratio * np.exp(exponent) / (2 * np.pi * variance)), variance


def clutter_density(model: BallModel, residuals: BlobResiduals) -> Array:
    """Density of clutter at each blob: (M, C, K) 1/px^2.

    The density is that of the blobs around the projection, less one, which may be the ball's. It is at least
    the usual density times `clutter_ratio`.
    """
    reach2 = np.square(model.neighbourhood * residuals.radius)
    near = (residuals.compatible & (residuals.squared_distance < reach2[..., None])).sum(axis=2)
    counted = np.maximum(near - 1, 0) / (np.pi * reach2)
    usual = (model.clutter / np.square(np.maximum(residuals.radius, model.minimum_radius)))[..., None]
    ratio = np.fmax(np.fmin(residuals.clutter_ratio, 1.0), MINIMUM_CLUTTER_RATIO)
    return np.asarray(np.maximum(counted[..., None], usual * ratio))


def likeliest_blobs(model: BallModel, residuals: BlobResiduals, rival_density: Array) -> LikeliestBlobs:
    """The likeliest blob of each view.

    rival_density: (M, C, K) 1/px^2, density of each blob as an image of the other targets.
    """
    density, variance = ball_densities(model, residuals)
    ratio = density / (clutter_density(model, residuals) + rival_density)
    slot = ratio.argmax(axis=2)
    at = (np.arange(len(slot))[:, None], np.arange(slot.shape[1]), slot)
    return LikeliestBlobs(slot, ratio[at], variance[at])


def view_log_ratios(detection: Array | float, blobs: LikeliestBlobs, in_picture: Array) -> Array:
    """Log-likelihood ratio of each view, (M, C): below 0 without a blob, 0 for a position out of its picture.

    detection: (M, C) or for all, probability that a view detects the ball that is there.
    """
    return np.asarray(np.log1p(detection * (blobs.ratio - 1.0)) * in_picture)


def precision(blobs: LikeliestBlobs, log_ratio: Array) -> Array:
    """Precision of the blob of each view, weighted by the probability that it is the ball's: (M, C) 1/px^2.

    log_ratio: (M, C) of :func:`view_log_ratios`.
    """
    return np.asarray(-np.expm1(-np.maximum(log_ratio, 0.0)) / blobs.variance)


def information(jacobian: Array, weight: Array) -> Array:
    """Information of each view on the position: (M, C, 3, 3) 1/m^2.

    jacobian: (M, C, 2, 3) px/m, of the projections by the position; weight: (M, C) 1/px^2, :func:`precision`.
    """
    return np.asarray((jacobian * weight[..., None, None]).swapaxes(2, 3) @ jacobian)


def log_occam_factors(views: Array, color: Array, prior: Array) -> Array:
    """Logarithms of Occam factors (MacKay 1992): (3, M), at most 0.

    A position that was chosen to fit the blobs also fits them by chance, and the wider the prior, the better
    it can fit. The factor corrects this: it is the volume of positions that the views leave possible, over
    the volume that was possible before. The three factors are those of all views, given the prior; of the
    infrared views, given the colour views; and of the colour views, given the infrared views.
    views: (M, C, 3, 3), :func:`information` of each; color: (C,) bool; prior: (M,) 1/m^2, information on the
    position.
    """
    known = np.eye(3) * prior[:, None, None]
    colored = views[:, color].sum(axis=1) + known
    infrared = views[:, ~color].sum(axis=1) + known
    stages = np.linalg.det(np.stack([known, colored, infrared, colored + infrared - known]))
    return np.asarray(0.5 * np.log(stages[:3] / stages[3]))


def ball_log_ratio(log_ratio: Array, color: Array, occam: Array, other: float) -> Array:
    """Log-likelihood ratio of a ball against the other things that could be there: (M,).

    Only colour cameras see coloured light and paint; only infrared cameras see a reflector. Each of these
    explains the views of its kind as well as a ball does. So if the room has both kinds, only both together
    tell a ball.
    log_ratio: (M, C) of the views; color: (C,) bool; occam: (3, M), :func:`log_occam_factors`; other:
    probability of paint, and of a reflector, over that of a ball.
    """
    if color.all() or not color.any():
        return np.asarray(log_ratio.sum(axis=1) + occam[0])
    colored, infrared = log_ratio[:, color].sum(axis=1), log_ratio[:, ~color].sum(axis=1)
    either = np.log(other) + np.logaddexp(-infrared - occam[1], -colored - occam[2])
    return np.asarray(-np.logaddexp(either, -infrared - colored - occam[0]))


def ball_vs_reflector_log_ratio(log_ratio: Array, color: Array, occam: Array) -> Array:
    """Log-likelihood ratio of a ball against a reflector, which infrared cameras alone show: (M,).

    That of :func:`ball_log_ratio` if the room has cameras of one kind only.
    """
    if color.all() or not color.any():
        return ball_log_ratio(log_ratio, color, occam, 1.0)
    return np.asarray(log_ratio[:, color].sum(axis=1) + occam[2])
