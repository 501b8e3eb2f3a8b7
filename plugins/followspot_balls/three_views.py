"""Three blobs of which each makes a pair with both others: hardly chance, however poor the pairs are."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates, Pairs


def threefold(pairs: Pairs | Candidates, possible: Array, sure: Array) -> Array:
    """Which possible pairs are sides of a triangle of possible ones of which one is sure.

    possible: (N, T) bool, for each target; sure: (N, T) bool, some of them. Returns (N, T) bool.
    """
    found = np.zeros(possible.shape, bool)
    for target in np.flatnonzero(sure.any(axis=0)):
        mine = possible[:, target].nonzero()[0]
        if len(mine) >= 3:
            blob = pairs.view[mine].astype(np.int64) << 32 | pairs.blob[mine]
            found[mine, target] = _sides(blob, sure[mine, target])
    return found


def _sides(blob: Array, sure: Array) -> Array:
    """As :func:`threefold`, for one target. blob: (N, 2) any numbers of the blobs; sure: (N,) bool."""
    blobs, end = np.unique(blob, return_inverse=True)
    end = end.reshape(blob.shape)
    first, second = end.T
    paired, side = np.zeros((2, len(blobs), len(blobs)), bool)
    paired[first, second] = paired[second, first] = True
    one, other = end[sure].T
    base, third = (paired[one] & paired[other]).nonzero()
    one, other = one[base], other[base]
    side[one, other] = side[one, third] = side[other, third] = True
    return np.asarray(side[first, second] | side[second, first])
