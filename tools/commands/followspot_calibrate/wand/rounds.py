"""Rounds of adjusting and of choosing the sightings that fit, until the choice stays the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Free, Middle, Progress, Rods, adjust
from followspot_calibrate.triangulation import error, triangulate

MOST_ROUNDS = 6
SETTLED = 0.001
"""Share of the sightings that may still change sides when the rounds end."""
SIGMAS = 5.0
"""Errors above as many standard deviations are outliers."""
SCALE = 2.385
"""Residual over sigma from which on weights fall: 95 % efficient for normal errors (Rey 1983)."""
LEAST_SIGMA = 0.02
"""px; below, sightings are as good as exact."""
RAYLEIGH = 1.1774
"""Median of the length of a 2D normal error over its standard deviation."""


@dataclass(frozen=True, eq=False)
class RobustAdjustment:
    """Cameras, points and the sightings that count.

    points: (N, 3) m, NaN if no two sightings agree; used: (N, C) bool; residual: (N, C, 2) px, seen minus
    expected, of every sighting, used or not; sigma: px, of one coordinate.
    """

    cameras: tuple[Camera, ...]
    points: Array
    used: Array
    residual: Array
    sigma: float

    @property
    def distance(self) -> Array:
        """Reprojection errors of the sightings that count, (N, C) px; NaN elsewhere."""
        return np.where(self.used, np.hypot(self.residual[..., 0], self.residual[..., 1]), np.nan)


class NothingFits(FollowspotError):
    """The cameras agree on no point."""


def adjust_robustly(
    cameras: Sequence[Camera],
    pixel: Array,
    free: Free,
    rods: Rods | None = None,
    middle: Middle | None = None,
    progress: Progress | None = None,
) -> RobustAdjustment:
    """Adjusts the cameras to all sightings, (N, C, 2) px, of which some are wrong; else as in `adjust`.

    Raises NothingFits.
    """
    adjusted = chosen(cameras, pixel)
    for number in range(MOST_ROUNDS):
        if not adjusted.used.any():
            raise NothingFits(
                "no two cameras agree on any point in the end: is all of the same recording, are the cameras "
                "synchronised, and was none moved?"
            )
        clean = np.where(adjusted.used[..., None], pixel, np.nan)
        better = adjust(
            adjusted.cameras,
            adjusted.points,
            clean,
            free,
            rods=rods,
            middle=middle,
            scale=SCALE * adjusted.sigma,
        )
        if progress is not None:
            progress("adjust", (number + 1) / MOST_ROUNDS)
        before, adjusted = adjusted, chosen(better.cameras, pixel)
        if (before.used != adjusted.used).mean() < SETTLED:
            break
    return adjusted


def chosen(cameras: Sequence[Camera], pixel: Array) -> RobustAdjustment:
    """The points as the cameras see them, and the sightings within `SIGMAS` of them."""
    found = triangulate(cameras, pixel)
    distance = error(found.residual)
    typical = float(np.median(distance[found.used])) if found.used.any() else np.inf
    sigma = max(typical / RAYLEIGH, LEAST_SIGMA)
    used = found.used & (distance < SIGMAS * sigma)
    used &= used.sum(axis=1, keepdims=True) >= 2
    points = np.where(used.any(axis=1, keepdims=True), found.points, np.nan)
    return RobustAdjustment(tuple(cameras), points, used, found.residual, sigma)
