"""Epipolar geometry of each pair of cameras: gross outliers fall, shared points are counted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from followspot.geometry import epipolar_distance
from followspot.messages import Array

FEWEST = 30
"""Points that a pair of cameras must share to count as connected."""
MOST = 400
"""Points of a pair that take part in the search; all are judged by its outcome."""
WORKING = 4000
"""Rows that the search of a beginning works with, over all pairs."""
SPREAD = 4
"""Rows are chosen, spread over the recording, if there are this many times as many."""
TRIALS = 2000
CONFIDENCE = 0.9999


@dataclass(frozen=True, eq=False)
class Pair:
    """Two cameras. rows: (M,) points that both saw; agree: (M,) bool, which fit one epipolar geometry."""

    first: int
    second: int
    rows: Array
    agree: Array

    @property
    def shared(self) -> int:
        """Points that both saw and that agree."""
        return int(self.agree.sum())


def match(xy: Array, limit: Array) -> list[Pair]:
    """The pairs of cameras and the sightings that fit the fundamental matrix of the pair (MAGSAC).

    xy: (N, C, 2) px without distortion, NaN if not seen; limit: (C,) px, the largest distance from the
    epipolar line in each camera.
    """
    seen = np.isfinite(xy[..., 0])
    pairs = []
    for a, b in combinations(range(xy.shape[1]), 2):
        rows = np.flatnonzero(seen[:, a] & seen[:, b])
        agree = agreeing(xy[rows, a], xy[rows, b], max(limit[a], limit[b]))
        pairs.append(Pair(a, b, rows, agree))
    return pairs


def trusted(pairs: list[Pair], shape: tuple[int, int]) -> Array:
    """Sightings that agree in more than half of the pairs that can judge them: (N, C) bool."""
    votes, asked = np.zeros(shape, int), np.zeros(shape, int)
    for pair in pairs:
        if pair.shared >= FEWEST:
            for camera in (pair.first, pair.second):
                asked[pair.rows, camera] += 1
                votes[pair.rows, camera] += pair.agree
    return np.asarray((2 * votes >= asked) & (votes > 0))


def agreeing(first: Array, second: Array, limit: float, trials: int = TRIALS) -> Array:
    """Which points, (M, 2) px in each view, fit the fundamental matrix that most fit: (M,) bool."""
    import cv2

    nothing = np.zeros(len(first), bool)
    if len(first) < FEWEST:
        return nothing
    chosen = np.linspace(0, len(first) - 1, min(len(first), MOST)).astype(int)
    F, _ = cv2.findFundamentalMat(
        first[chosen], second[chosen], cv2.USAC_MAGSAC, limit / 2, CONFIDENCE, trials
    )
    if F is None or F.shape != (3, 3):
        return nothing
    return epipolar_distance(F, first, second) < limit


def working_rows(pairs: Sequence[Pair], fits: Array) -> Array:
    """Some rows that represent all pairs, for the search of a beginning: numbers, ascending.

    fits: (N, C) bool, the sightings that are trusted; rows that many cameras saw come first.
    """
    views = fits.sum(axis=1)
    quota = max(FEWEST, WORKING // max(1, len(pairs)))
    chosen = np.zeros(len(fits), bool)
    for pair in pairs:
        rows = pair.rows[fits[pair.rows, pair.first] & fits[pair.rows, pair.second]]
        spread = rows[np.linspace(0, len(rows) - 1, min(len(rows), SPREAD * quota)).astype(int)]
        lacking = max(0, quota - int(chosen[rows].sum()))
        chosen[spread[np.argsort(-views[spread], kind="stable")[:lacking]]] = True
    return np.flatnonzero(chosen)
