"""A wand of two points: rows labelled 0 and 1 of one frame are a known length apart."""

from __future__ import annotations

import numpy as np

from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Rods
from followspot_calibrate.sightings import Sightings

SIGMA = 0.001
"""Accuracy of the length of a wand, m."""
FEWEST = 10
"""Frames in which the whole wand must be seen."""


def rods_of(sightings: Sightings, length: float) -> Rods:
    """The wand in each frame that has both of its points. Raises FollowspotError if there are too few."""
    one, other = (np.flatnonzero(sightings.label == label) for label in (0, 1))
    _, first, second = np.intersect1d(sightings.frame[one], sightings.frame[other], return_indices=True)
    if len(first) < FEWEST:
        raise FollowspotError(
            f"--length needs frames with the points 0 and 1 of the wand: {len(first)} have both, "
            f"{FEWEST} needed; label them in the column point, or leave --length out"
        )
    return Rods(one[first], other[second], length, SIGMA)


def scale_of(points: Array, rods: Rods) -> float:
    """Factor for points, (N, 3), that gives the wand its length in the median.

    Raises FollowspotError if the wand is hardly ever seen whole.
    """
    lengths = measured(points, rods)
    if np.isfinite(lengths).sum() < FEWEST:
        raise FollowspotError("the two points of the wand are hardly ever seen by two cameras at once")
    return float(np.nanmedian(rods.length / lengths))


def measured(points: Array, rods: Rods) -> Array:
    """The wand's length in each frame, (S,); NaN if an end is unknown."""
    return np.asarray(np.linalg.norm(points[rods.first] - points[rods.second], axis=1))
