"""Whether the ends of boxes of two cameras meet at the heights of a standing person's head and feet."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.assignment.affinity import points_between
from followspot_persons.associate.boxes.shape_mixture import UPRIGHT
from followspot_persons.associate.multi_view.views import Views

HEIGHTS, SIGMA = np.array([2 * np.exp(UPRIGHT.mean[1]), 0.0]), 0.15
"""Heights of the upper and the lower end of a person above the floor, along z, and their sigma, m."""
SHARE = 0.7
"""Share of ends that are there: some people lie, jump or sit, and some ends are hidden."""
LIMIT = 3 * SIGMA
"""Largest distance of one end alone from its height, m."""
RANGE = 15.0
"""Range of heights at which ends of different people meet, m."""


def off_standing(ends: Array, floor: Array) -> Array:
    """How far upper and lower ends are above those of a standing person, (P, 2) m. ends: (P, 2, 3) m; floor:
    (4,) of its plane.
    """
    return np.asarray((ends @ floor[:3] + floor[3]) / floor[2] - HEIGHTS)


def stands(ends: Array, floor: Array) -> Array:
    """Whether pairs that share one end alone may be a standing person, (P,): a picture cuts off the other.

    ends, floor: as of :func:`off_standing`.
    """
    near = np.abs(off_standing(ends, floor)) < LIMIT  # not if an end is NaN
    return np.asarray((np.isfinite(ends).all(axis=2).sum(axis=1) == 1) & near.any(axis=1))


def standing_ratios(views: Views, camera: Array, ends: Array, floor: Array, a: Array, b: Array) -> Array:
    """Log-likelihood ratios that pairs of boxes are one person, (P,), by the heights of their ends.

    camera: (N,); ends: (N, 2, 2) px, upper and lower ones, NaN if unknown, which tell nothing; floor: (4,) of
    its plane; a, b: (P,) boxes of each pair.
    """
    above = off_standing(points_between(views, camera, ends, a, b), floor)
    density = np.exp(-0.5 * (above / SIGMA) ** 2) / (np.sqrt(2 * np.pi) * SIGMA)
    ratio = np.log(SHARE * RANGE * density + 1 - SHARE)
    return np.asarray(np.where(np.isfinite(ratio), ratio, 0.0).sum(axis=1))
