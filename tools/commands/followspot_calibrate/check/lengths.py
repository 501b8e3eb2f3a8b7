"""A known length, measured: the distance of a wand's two points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.errors import FollowspotError
from followspot.messages import Array

FEWEST = 10
TOLERANCE = 0.01
"""Largest deviation of a good room's scale."""
GROSS = 5.0
"""Lengths further from the median than so many sigma are of something else."""


@dataclass(frozen=True, eq=False)
class MeasuredLength:
    """A known length, m, and the mean and one sigma of count measurements, mm."""

    true_m: float
    mean_mm: float
    sigma_mm: float
    count: int

    @property
    def ratio(self) -> float:
        """Measured over true: the room's scale is off by so much."""
        return self.mean_mm / (1000 * self.true_m)

    @property
    def good(self) -> bool:
        """True if the scale is right."""
        return abs(self.ratio - 1) <= TOLERANCE


def measured_length(points: Array, frame: Array, label: Array, length: float) -> MeasuredLength:
    """The distance of points 0 and 1 of the same frames. Raises FollowspotError for too few of them.

    points: (N, 3) m, NaN if unknown; frame, label: (N,); length: m.
    """
    one, other = (np.flatnonzero(label == number) for number in (0, 1))
    _, first, second = np.intersect1d(frame[one], frame[other], return_indices=True)
    apart = np.linalg.norm(points[one[first]] - points[other[second]], axis=1)
    apart = apart[np.isfinite(apart)]
    if len(apart) < FEWEST:
        raise FollowspotError(
            f"--length: {len(apart)} frames show points 0 and 1 of the wand to two cameras, {FEWEST} needed; "
            "the points' file needs a column point with 0 and 1"
        )
    middle = np.median(apart)
    sigma = 1.4826 * np.median(np.abs(apart - middle))
    kept = apart[np.abs(apart - middle) <= max(GROSS * sigma, 1e-9)]
    return MeasuredLength(length, float(1000 * kept.mean()), float(1000 * kept.std()), len(kept))
