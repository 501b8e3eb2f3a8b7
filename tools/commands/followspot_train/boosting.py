"""Boosted trees of two levels by Newton steps on the cross entropy (Friedman 2001), in numpy.

Each tree chooses among some features only, and learns from the windows that are still in doubt, as the
detectors of Dollár et al. 2014 ("Fast feature pyramids for object detection") do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot import Array
from followspot_persons.hog.trees import Trees

TREES = 600
RATE = 0.1
"""Share of each Newton step that is taken."""
TRIED = 120
"""Features that a tree chooses among, drawn anew for each."""
BINS = 32
"""Thresholds are the quantiles between so many parts of the rows."""
RIDGE = 1.0
LEAST = 1.0
"""Smallest sum of second derivatives in a leaf."""
DOUBT = 0.98
"""Share of all error whose rows a tree is chosen by; rows that are sure take no part."""
AGAIN = 5
"""Trees after which these rows are chosen anew."""
SAMPLE = 8000
"""Rows that quantiles are taken from."""


def train(
    features: Array, person: Array, rng: np.random.Generator, report_progress: Callable[[str], None]
) -> Trees:
    """Trees that tell persons from others.

    features: (N, D); person: (N,) 1 or 0; report_progress: called with a line.
    """
    edges, codes = _coded(features, rng)
    odds = np.full(len(person), np.log(person.sum() / (len(person) - person.sum())))
    feature, bound = np.zeros((TREES, 3), np.intp), np.zeros((TREES, 3), np.intp)
    leaves, known = np.zeros((TREES, 4)), odds[0]
    for tree in range(TREES):
        share = 1 / (1 + np.exp(-odds))
        slope, bend = person - share, np.maximum(share * (1 - share), 1e-6)
        if tree % AGAIN == 0:
            report_progress(f"growing trees, {tree} of {TREES}")
            rows = _doubtful(slope)
        tried = rng.choice(len(codes), min(TRIED, len(codes)), replace=False)
        feature[tree, 0], bound[tree, 0] = _split(codes, tried, rows, slope, bend)
        right = codes[feature[tree, 0]] > bound[tree, 0]
        place = 2 * right.astype(np.intp)
        for side in (0, 1):
            own = rows[right[rows] == side]
            asked, at = feature[tree, 1 + side], bound[tree, 1 + side] = _split(
                codes, tried, own, slope, bend
            )
            place += (right == side) & (codes[asked] > at)
        step = np.bincount(place, slope, 4) / (np.bincount(place, bend, 4) + RIDGE)
        leaves[tree] = RATE * step
        odds += leaves[tree, place]
    leaves[0] += known
    return Trees(feature, edges[bound, feature], leaves.astype(np.float32))


def _coded(features: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Quantiles (BINS - 1, D), and for each feature how many of them each row exceeds, (D, N) u1."""
    sample = features[rng.permutation(len(features))[:SAMPLE]]
    edges = np.quantile(sample.astype(np.float32), np.arange(1, BINS) / BINS, axis=0).astype(np.float32)
    codes = np.empty(features.shape[::-1], np.uint8)
    for code, edge, feature in zip(codes, edges.T, features.T, strict=True):
        code[:] = np.searchsorted(edge, feature.astype(np.float32), side="left")
    return edges, codes


def _doubtful(slope: Array) -> Array:
    """Rows with most of the error."""
    order = np.argsort(-np.abs(slope))
    share = np.cumsum(np.abs(slope[order]))
    return np.sort(order[: np.searchsorted(share, DOUBT * share[-1]) + 1])


def _split(codes: Array, tried: Array, rows: Array, slope: Array, bend: Array) -> tuple[int, int]:
    """The feature and the number of the quantile that part rows best."""
    count = len(tried)
    cells = (codes[tried[:, None], rows] + BINS * np.arange(count)[:, None]).ravel()
    slopes, bends = (
        np.bincount(cells, np.tile(d[rows], count), count * BINS).reshape(count, BINS).cumsum(axis=1)
        for d in (slope, bend)
    )
    left, low = slopes[:, :-1], bends[:, :-1]
    right, high = slopes[:, -1:] - left, bends[:, -1:] - low
    gain = left**2 / (low + RIDGE) + right**2 / (high + RIDGE)
    gain[(low < LEAST) | (high < LEAST)] = -1
    best, at = divmod(int(gain.argmax()), BINS - 1)
    return int(tried[best]), at
