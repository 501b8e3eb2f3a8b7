"""Hue histograms and their similarity (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array

BINS = 16
BIT = np.append(1 << np.arange(BINS), (1 << BINS) - 1).astype(np.uint16)
"""(17,) the bit of each bin, then all bits, for pixels of unknown hue."""


def hue_bin(hue: Array) -> Array:
    """b(q) of eq. 1: OpenCV's full-range hue (0..255) -> bin 0..15."""
    return hue >> 4


def normalised(counts: Array) -> Array:
    """Scale histograms to sum 1 (lambda of eq. 1): (..., 16) -> (..., 16); an empty one stays zero."""
    total = counts.sum(axis=-1, keepdims=True)
    return np.asarray(counts / np.maximum(total, np.finfo(float).tiny))


def bhattacharyya(a: Array, b: Array) -> Array:
    """Similarity of normalised histograms, sum_b sqrt(a_b b_b) (eq. 2): 0 nothing in common, 1 equal.

    a, b: (..., 16), broadcast. Returns (...,).
    """
    return np.asarray(np.sqrt(a * b).sum(axis=-1))


def hue_bits(histograms: Array, share: float) -> Array:
    """Which hues belong to each target's histogram, as bits, of which each bin has its `BIT`.

    histograms: (T, 16) normalised; share: smallest part of the histogram that a bin must hold.
    Returns (T,) u16.
    """
    return np.asarray(((histograms >= share) << np.arange(BINS)).sum(axis=-1).astype(np.uint16))
