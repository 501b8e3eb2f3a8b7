"""Likelihood ratio of a ball against clutter, from the blobs of all views.

A ball shows to a view as a disc of known radius, of which people may cover a part; clutter as a Poisson
process of blobs (Bar-Shalom, Daum & Huang 2009, the probabilistic data association filter).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.measurement.center_precision import WHOLE

RARE = 0.02
"""Least share of the usual clutter: what a view never showed may still appear."""


class BallModel(NamedTuple):
    """How balls and clutter show."""

    detection: float
    """Probability that a view shows a ball that is there; people cover it often."""
    clutter: float
    """Usual density of clutter, blobs in a square whose side is the ball's radius."""
    neighbourhood: float
    """Radius around a ball's image in which other blobs count as clutter, over the ball's."""
    sigma: float
    """Sigma of the centre of a whole ball, px."""
    relative_sigma: float
    """What adds to it, over the radius of the ball's image."""
    hidden_sigma: float
    """What an outline adds to it that is all hidden, likewise."""
    smallest: Array | float = 0.0
    """(C,) radius of a ball's image below which clutter is no denser, px."""


class Sight(NamedTuple):
    """K blobs of C views as seen from M hypotheses, each a place of a target."""

    squares: Array
    """(M, C, K) squared distances of the blobs from the image of the place, px^2."""
    share: Array
    """(M, C, K) area of the blobs over that of the target's outline."""
    radius: Array
    """(M, C) radius of the target's image, px."""
    possible: Array
    """(M, C, K) bool, whether the blob may show the target."""
    inside: Array
    """(M, C) bool, whether the place has an image in the picture."""
    clutter: Array
    """(C, K) share of the usual clutter around each blob."""


class Likely(NamedTuple):
    """The likeliest blob of each view."""

    slot: Array
    """(M, C)."""
    ratio: Array
    """(M, C) its density as the ball over that of whatever else it may be."""
    variance: Array
    """(M, C) of its distance from the image, px^2."""


def densities(model: BallModel, sight: Sight, spread: Array | float = 0.0) -> tuple[Array, Array]:
    """Densities of blobs, 1/px^2, of a ball at the place, and variances of their centres, px^2: (M, C, K).

    A covered disc has its centre off by a part of the radius; a blob merged with other light too. Clutter
    is as likely of any size up to the ball's, but a ball shows more of itself rather than less: a fragment is
    poor evidence.
    spread: variance of the image of the place, px^2.
    """
    size = sight.radius[..., None]
    off = model.hidden_sigma * np.maximum(1.0 - sight.share, 0.0) + np.maximum(sight.share - WHOLE, 0.0)
    variance = model.sigma**2 + (np.square(model.relative_sigma) + np.square(off)) * np.square(size) + spread
    size_ratio = 2.0 * np.minimum(sight.share, 1.0) * sight.possible
    return np.asarray(size_ratio * np.exp(-0.5 * sight.squares / variance) / (2 * np.pi * variance)), variance


def clutter_density(model: BallModel, sight: Sight) -> Array:
    """Density of clutter at each blob: (M, C, K) 1/px^2.

    From the blobs around each image but one, the ball's, and at least the share of the usual density.
    """
    reach2 = np.square(model.neighbourhood * sight.radius)
    near = (sight.possible & (sight.squares < reach2[..., None])).sum(axis=2)
    counted = np.maximum(near - 1, 0) / (np.pi * reach2)
    usual = (model.clutter / np.square(np.maximum(sight.radius, model.smallest)))[..., None]
    share = np.fmax(np.fmin(sight.clutter, 1.0), RARE)
    return np.asarray(np.maximum(counted[..., None], usual * share))


def likeliest(model: BallModel, sight: Sight, rivals: Array) -> Likely:
    """The likeliest blob of each view. rivals: (M, C, K) 1/px^2, densities of the blobs as other targets."""
    density, variance = densities(model, sight)
    ratio = density / (clutter_density(model, sight) + rivals)
    slot = ratio.argmax(axis=2)
    at = (np.arange(len(slot))[:, None], np.arange(slot.shape[1]), slot)
    return Likely(slot, ratio[at], variance[at])


def view_ratios(shown: Array | float, likely: Likely, inside: Array) -> Array:
    """Log-likelihood ratio of each view, (M, C): below 0 without a blob, 0 if it cannot see the place.

    shown: (M, C) or for all, probability that a view shows the ball that is there.
    """
    return np.asarray(np.log1p(shown * (likely.ratio - 1.0)) * inside)


def precision(likely: Likely, views: Array) -> Array:
    """Precision of the blob of each view, weighted by the probability that it is the ball's: (M, C) 1/px^2.

    views: (M, C) of :func:`view_ratios`.
    """
    return np.asarray(-np.expm1(-np.maximum(views, 0.0)) / likely.variance)


def information(jacobian: Array, weight: Array) -> Array:
    """Information of each view on the place: (M, C, 3, 3) 1/m^2.

    jacobian: (M, C, 2, 3) px/m, of the images by the place; weight: (M, C) 1/px^2, :func:`precision`.
    """
    return np.asarray((jacobian * weight[..., None, None]).swapaxes(2, 3) @ jacobian)


def coincidences(views: Array, color: Array, prior: Array) -> Array:
    """Logarithms of the shares of the possible places at which the views agree as they do: (3, M), at most 0.

    A place that was chosen to fit the blobs fits them by coincidence, too, the more so the less was known of
    it: of all views, given what was known; of infrared views, given the colour views; and the reverse.
    views: (M, C, 3, 3), :func:`information`; color: (C,) bool; prior: (M,) 1/m^2, information on the place.
    """
    known = np.eye(3) * prior[:, None, None]
    colored, infrared = views[:, color].sum(axis=1) + known, views[:, ~color].sum(axis=1) + known
    stages = np.linalg.det(np.stack([known, colored, infrared, colored + infrared - known]))
    return np.asarray(0.5 * np.log(stages[:3] / stages[3]))


def ball_ratio(views: Array, color: Array, chance: Array, other: float) -> Array:
    """Log-likelihood ratio of a ball against whatever else could be there: (M,).

    Coloured light or paint shows to colour cameras alone and a reflector to infrared cameras alone. Each
    explains the views of its kind as well as a ball does, so only both kinds together tell a ball, where
    there are both.
    views: (M, C); color: (C,) bool; chance: (3, M), :func:`coincidences`; other: probability of paint, and of
    a reflector, over that of a ball.
    """
    if color.all() or not color.any():
        return np.asarray(views.sum(axis=1) + chance[0])
    colored, infrared = views[:, color].sum(axis=1), views[:, ~color].sum(axis=1)
    either = np.log(other) + np.logaddexp(-infrared - chance[1], -colored - chance[2])
    return np.asarray(-np.logaddexp(either, -infrared - colored - chance[0]))


def reflector_ratio(views: Array, color: Array, chance: Array) -> Array:
    """Log-likelihood ratio of a ball against a reflector, which infrared cameras alone show: (M,).

    That of :func:`ball_ratio` where cameras of one kind are all there are.
    """
    if color.all() or not color.any():
        return ball_ratio(views, color, chance, 1.0)
    return np.asarray(views[:, color].sum(axis=1) + chance[2])
