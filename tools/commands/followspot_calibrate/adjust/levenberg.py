"""Robust bundle adjustment by Levenberg and Marquardt, with derivatives in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.adjust.prior import Prior
from followspot_calibrate.adjust.problem import Anchors, Estimate, Middle, Problem, view_of
from followspot_calibrate.adjust.projection import Free
from followspot_calibrate.adjust.rods import NO_RODS, Rods, groups_of

MOST_STEPS = 100
CONVERGED = 1e-7
"""Relative decrease of the cost at which the adjustment ends."""
DAMPING = (1e-12, 1e-4, 1e8)
"""Smallest, first and largest."""

Progress = Callable[[str, float], None]
"""Receives the present step as text, and the completed share, 0 to 1."""


@dataclass(frozen=True, eq=False)
class Adjusted:
    """The result of an adjustment: points (N, 3) m; residual (N, C) px, NaN if not seen; steps taken."""

    cameras: tuple[Camera, ...]
    points: Array
    residual: Array
    steps: int


def adjust(
    cameras: Sequence[Camera],
    points: Array,
    pixel: Array,
    free: Free,
    *,
    rods: Rods | None = None,
    middle: Middle | None = None,
    anchors: Anchors | None = None,
    prior: Prior | None = None,
    scale: float | Array = 1.0,
    progress: Progress | None = None,
) -> Adjusted:
    """Cameras and points with the smallest robust reprojection error (Cauchy loss of the distance in px).

    points: (N, 3) m, a start; pixel: (N, C, 2) px as in the picture, NaN if not seen; scale: px, of
    each point, (N,), or of all, where an error begins to count as an outlier. What is off by its sigma, a rod
    in length, a principal point from its expected middle, a camera from its anchor or its prior (poses
    must be free), costs about as much as a point off by `scale`. Rows seen by fewer than two cameras, or
    without a start (NaN), take no part and stay. The frame of reference is left to the start, but for rods,
    which set the length, anchors and prior. A camera other than pinhole keeps its intrinsics.
    Raises ValueError for a scale that is not positive.
    """
    if not np.all(np.asarray(scale) > 0):
        raise ValueError(f"scale is {scale}, it must be above 0 px")
    seen = np.isfinite(pixel).all(axis=2)
    usable = np.isfinite(points).all(axis=1) & (seen.sum(axis=1) >= 2)
    flat, views = zip(*(view_of(c, pixel[usable, i], free) for i, c in enumerate(cameras)), strict=True)
    tied = (rods or NO_RODS).within(usable)
    scales = np.broadcast_to(scale, len(points))[usable]
    groups = groups_of(int(usable.sum()), tied)
    problem = Problem(views, tied, groups, scales, free.parameters, middle, anchors, prior)
    best, steps = _descend(problem, Estimate(flat, points[usable]), progress)
    found = points.copy()
    found[usable] = best.points
    final = tuple(_adjusted(*pair) for pair in zip(cameras, best.cameras, strict=True))
    return Adjusted(final, found, residuals(final, found, pixel), steps)


def residuals(cameras: Sequence[Camera], points: Array, pixel: Array) -> Array:
    """Distance of points from their sightings: (N, C) px; NaN if not seen or behind the camera."""
    away = [np.linalg.norm(project(c, points) - pixel[:, i], axis=1) for i, c in enumerate(cameras)]
    return np.stack(away, axis=1)


def _descend(problem: Problem, estimate: Estimate, progress: Progress | None) -> tuple[Estimate, int]:
    """Steps downhill until they gain nothing; damped more after a failure, less after a success."""
    least, damping, most = DAMPING
    cost = problem.cost(estimate)
    for steps in range(MOST_STEPS):
        if progress is not None:
            progress("adjust", steps / MOST_STEPS)
        normal = problem.normal(estimate)
        better, after = None, cost
        while better is None and damping < most:
            trial = problem.step(normal, estimate, damping)
            after = np.inf if trial is None else problem.cost(trial)
            better = trial if after < cost else None
            damping = damping * 10 if better is None else max(damping / 10, least)
        if better is None:
            return estimate, steps
        gained, estimate, cost = cost - after, better, after
        if gained <= CONVERGED * cost:
            return estimate, steps + 1
    return estimate, MOST_STEPS


def _adjusted(before: Camera, after: Camera) -> Camera:
    """The camera in its own lens model."""
    if before.model == "pinhole":
        return after
    return replace(before, rotation=after.rotation, translation=after.translation)
