"""Targets of similar colours: a blob that two templates accept belongs to the one that it fits best."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_balls.detection.hue import BINS

TOLD_APART = 0.99
"""Similarity of two templates below which they tell blobs apart; the noise of a blob of 30 px is less."""


def rivals(histograms: Array, hues: Array, similarity: float, smallest: float) -> Array:
    """Which targets are taken for each other in a camera, though they can be told apart: (T, T) bool.

    A template looks at the pixels of its own hues alone; of another target's blob these may be like it.
    The result is symmetric.
    histograms: (T, 16) normalised; hues: (T,) u16, bits of their hues; similarity: from which a blob is
    accepted; smallest: share of a usual blob that is large enough for one.
    """
    seen = (hues[:, None] >> np.arange(BINS) & 1).astype(bool)
    roots = np.sqrt(histograms)
    share = histograms @ seen.T
    taken = (share >= smallest) & (roots @ (roots * seen).T > similarity * np.sqrt(share))
    return np.asarray((taken | taken.T) & (roots @ roots.T < TOLD_APART))


def best_fitting(pixel: Array, area: Array, similarity: Array, owner: Array, rival: Array) -> Array:
    """Which of N blobs no rival of their targets fits better: (N,) bool.

    The similarity that counts is that to all coloured pixels of a blob, also those that a template left out:
    it is larger the more pixels the template has of the blob.
    pixel: (N, 2); owner: (N,) row of the target among those of all views; rival: (rows, T) of `rivals`.
    """
    view, target = np.divmod(owner, rival.shape[1])
    same = (view[:, None] == view) & rival[owner[:, None], target]
    apart = np.linalg.norm(pixel[:, None] - pixel, axis=2)
    near = apart**2 * np.pi <= np.maximum(area[:, None], area)
    fit = similarity**2 * area
    return np.asarray(~(same & near & (fit > fit[:, None])).any(axis=1))
