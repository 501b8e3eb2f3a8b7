"""Percentage of correct parts of skeletons in the room (Ferrari et al. 2008; in 3D Burenius et al. 2013)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.messages import Array

ALPHA = 0.5
"""Mean distance of both ends from the true ones, over the true length, up to which a part is correct."""


def correct_parts(found: Array, true: Array, parts: Sequence[tuple[int, int]]) -> Array:
    """Which parts of each true person are correct in the skeleton that is nearest to it, (P, B) bool.

    found: (M, J, 3) m, true: (P, J, 3) m, NaN where a joint is not known; parts: B pairs of joints. A part
    that was not found is wrong, and so is one whose truth is not known.
    """
    apart = np.linalg.norm(true[:, None] - found[None], axis=-1)
    known = np.isfinite(apart)
    total = np.where(known, apart, 0.0).sum(axis=-1)
    mean = np.divide(total, known.sum(axis=-1), out=np.full(total.shape, np.inf), where=known.any(axis=-1))
    a, b = np.reshape(parts, (-1, 2)).T
    if not len(found):
        return np.zeros((len(true), len(a)), bool)
    of_nearest = np.take_along_axis(apart, mean.argmin(axis=1)[:, None, None], axis=1)[:, 0]
    length = np.linalg.norm(true[:, a] - true[:, b], axis=-1)
    return np.asarray((of_nearest[:, a] + of_nearest[:, b]) / 2 <= ALPHA * length)
