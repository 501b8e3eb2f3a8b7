"""The likelihood of differences between the colours of a body's features (F^CD, section 3.3 and eq. 7).

Light that brightens the whole person changes colours and leaves their differences. Pairs of features are
those whose colours differ most in people, such as face and hair: a plain wall would fit all others.
"""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.body.shape import ShapeModel
from followspot_persons.color.difference import ColorRelations
from followspot_persons.color.hsi import plane
from followspot_persons.color.likelihood import FLOOR, NARROWEST

PAIRS = 120
"""Number of pairs."""
TOGETHER = 0.0
"""Smallest cosine between the directions of the features of a pair: farther ones are hardly seen together."""
NOTHING_SEEN = 0.45
"""Likelihood of a pose that shows no pair: between those of a person and of the background."""


def telling_pairs(shape: ShapeModel, relations: ColorRelations) -> Array:
    """The pairs of features that differ most in people and are seen together, (2, pairs)."""
    first, second = np.triu_indices(len(shape.names), 1)
    outward = shape.surface.outward
    cosine = (outward[first] * outward[second]).sum(axis=1)
    spread = 2 * _variance_of_difference(relations.chroma, first, second)
    spread += _variance_of_difference(relations.intensity, first, second)
    square = ((relations.mean[first] - relations.mean[second]) ** 2).sum(axis=1) + spread
    best = np.argsort(np.where(cosine >= TOGETHER, -square, np.inf), kind="stable")[:PAIRS]
    best = best[cosine[best] >= TOGETHER]
    return np.stack([first[best], second[best]])


def _variance_of_difference(covariance: Array, first: Array, second: Array) -> Array:
    own = np.diag(covariance)
    return np.asarray(own[first] + own[second] - 2 * covariance[first, second])


def pair_responses(colors: Array, mean: Array, variance: Array, pairs: Array) -> Array:
    """Gaussians of the differences, relative to the peak of the narrowest one, mixed as in eq. 5.

    colors: (P, F, 3) HSI; mean, variance: (F, 3) of the person; pairs: (2, N). Returns (P, N), 0 to 1.
    """
    residual = plane(colors) - plane(mean)
    apart = residual[:, pairs[0]] - residual[:, pairs[1]]
    wide = _plane_variance(mean, variance)
    wide = wide[pairs[0]] + wide[pairs[1]]
    narrow = 2 * NARROWEST[1:] ** 2
    wide = np.maximum(wide, narrow)
    chroma = np.exp(-0.5 * (apart[..., 0] ** 2 + apart[..., 1] ** 2) / wide[:, 0]) * (narrow[0] / wide[:, 0])
    intensity = np.exp(-0.5 * apart[..., 2] ** 2 / wide[:, 1]) * np.sqrt(narrow[1] / wide[:, 1])
    return np.asarray((2 * chroma + intensity) / 3)


def _plane_variance(mean: Array, variance: Array) -> Array:
    """Variances of HSI as those of one coordinate of the chroma and of the intensity. (F, 2)."""
    hue = (2 * np.pi * mean[:, 1]) ** 2 * variance[:, 0]
    return np.column_stack([(hue + variance[:, 1]) / 2, variance[:, 2]])


def difference_likelihood(responses: Array, visibility: Array, pairs: Array) -> Array:
    """F^CD: geometric mean over the pairs, weighted by the visibility of both features.

    responses: (P, N) of :func:`pair_responses`; visibility: (P, F); pairs: (2, N). Returns (P,), 0 to 1.
    """
    weight = visibility[:, pairs[0]] * visibility[:, pairs[1]]
    total = weight.sum(axis=1)
    logs = np.log(np.maximum(responses, FLOOR))
    mean = np.exp((weight * logs).sum(axis=1) / np.maximum(total, 1e-6))
    return np.where(total > 1e-6, mean, NOTHING_SEEN)
