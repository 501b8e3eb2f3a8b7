"""Rigidity of the triangulated board: distances between its corners against the printed ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_calibrate.boards.board import Board

MOST_PAIRS = 2000
"""Largest number of pairs of corners per moment, evenly spread over all pairs."""


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances between corners of one board at one moment.

    first, second: (P,) rows; printed, measured: (P,) m.
    """

    first: Array
    second: Array
    printed: Array
    measured: Array

    @property
    def scale(self) -> float:
        """Factor from measured to printed lengths: the median ratio."""
        return float(np.median(self.printed / self.measured))

    @property
    def rmse_mm(self) -> float:
        """Root mean square difference of measured and printed distances, mm."""
        return float(1000 * np.sqrt(np.square(self.measured - self.printed).mean()))


def distances(frame: Array, label: Array, points: Array, board: Board) -> Distances:
    """Pairs of known corners of the same moment.

    frame, label: (N,), in the order of moments; points: (N, 3) m, NaN if not known.
    """
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    starts = np.flatnonzero(np.diff(frame[known], prepend=-1))
    groups = np.split(known, starts[1:]) if len(known) else []
    both = [rows[_pairs(len(rows))] for rows in groups]
    first, second = np.concatenate([np.empty((2, 0), np.int64), *both], axis=1)
    corners = board.corners[label]
    return Distances(
        first,
        second,
        np.linalg.norm(corners[first] - corners[second], axis=1),
        np.linalg.norm(points[first] - points[second], axis=1),
    )


def _pairs(count: int) -> Array:
    """Pairs of this many things, (2, P)."""
    pairs = np.array(np.triu_indices(count, 1))
    return pairs[:, :: max(1, -(-pairs.shape[1] // MOST_PAIRS))]
