"""Triples of blobs that all pair with each other: rarely a coincidence, even if the pairs are weak."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates, Pairs


def threefold(pairs: Pairs | Candidates, possible: Array, sure: Array) -> Array:
    """Which possible pairs are sides of a triangle of possible pairs with at least one sure side.

    possible: (N, T) bool, for each target; sure: (N, T) bool, some of them. Returns (N, T) bool.
    """
    found = np.zeros(possible.shape, bool)
    sought = np.flatnonzero(sure.any(axis=0))
    if not len(sought):
        return found
    row, target = possible[:, sought].nonzero()
    number_in_view = pairs.blob[row].view(np.uint32)  # a host may send negative ones, which no blob has
    blob = (target[:, None] << 48) + (pairs.view[row].astype(np.int64) << 32) + number_in_view
    blobs, number = np.unique(blob, return_inverse=True)
    before = np.searchsorted(blobs, np.arange(len(sought) + 1) << 48)
    first, second = number.reshape(blob.shape).T - before[target]
    most = np.diff(before).max()
    paired, side = np.zeros((2, len(sought), most, most), bool)
    paired[target, first, second] = paired[target, second, first] = True
    base = sure[row, sought[target]].nonzero()[0]
    of, one, other = target[base], first[base], second[base]
    base, third = (paired[of, one] & paired[of, other]).nonzero()
    of, one, other = of[base], one[base], other[base]
    side[of, one, other] = side[of, one, third] = side[of, other, third] = True
    found[row, sought[target]] = side[target, first, second] | side[target, second, first]
    return found
