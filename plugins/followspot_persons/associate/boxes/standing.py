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
RANGE = 15.0
"""Range of heights at which ends of different people meet, m."""


def standing_ratios(views: Views, camera: Array, ends: Array, floor: Array, a: Array, b: Array) -> Array:
    """Log-likelihood ratios that pairs of boxes are one person, (P,), by the heights of their ends.

    camera: (N,); ends: (N, 2, 2) px, upper and lower ones, NaN if unknown, which tell nothing; floor: (4,) of
    its plane; a, b: (P,) boxes of each pair.
    """
    xyz = points_between(views, camera, ends, a, b)
    level = (xyz @ floor[:3] + floor[3]) / floor[2]
    density = np.exp(-0.5 * ((level - HEIGHTS) / SIGMA) ** 2) / (np.sqrt(2 * np.pi) * SIGMA)
    ratio = np.log(SHARE * RANGE * density + 1 - SHARE)
    return np.asarray(np.where(np.isfinite(ratio), ratio, 0.0).sum(axis=1))
