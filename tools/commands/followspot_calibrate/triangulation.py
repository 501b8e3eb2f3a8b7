"""Points of the room from sightings, some of which are wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from followspot.geometry import Views, ray, triangulate_pairs, triangulate_views
from followspot.messages import Array
from followspot.room import Camera

SHARE = 0.01
"""Largest reprojection error of a sighting that counts, over the longer side of the picture."""
ROUNDS = 3
"""Rounds of solving for the points and selecting the views that agree; more change nothing."""


@dataclass(frozen=True, eq=False)
class Triangulated:
    """Points of the room and how well their sightings fit.

    points: (N, 3) m, NaN if no two views agree; used: (N, C) bool, views that agree;
    residual: (N, C, 2) px, seen minus expected, of every sighting of a known point, used or not.
    """

    points: Array
    used: Array
    residual: Array


def triangulate(cameras: Sequence[Camera], pixel: Array) -> Triangulated:
    """Points from all views that agree; a wrong sighting does not spoil a point.

    Each pair of views proposes a point; the proposal with the least cost over all views wins, where a view
    costs its squared error over the squared limit, at most 1 (MSAC, Torr & Zisserman 2000). Then the
    point is solved for from the views within the limit, `SHARE` of the picture.
    pixel: (N, C, 2) px with lens distortion, NaN if not seen.
    """
    views, rays = Views(cameras), rays_of(cameras, pixel)
    seen, limit = np.isfinite(rays[..., 0]), limits(cameras)
    points = _proposed(views, rays, pixel, limit)
    for _ in range(ROUNDS):
        used = seen & (error(residuals(views, points, pixel)) < limit)
        points = solved(views, rays, used, points)
    used &= np.isfinite(points[:, :1])
    return Triangulated(points, used, residuals(views, points, pixel))


def leave_one_out(cameras: Sequence[Camera], pixel: Array, found: Triangulated) -> Array:
    """Residuals of each view from the point that the other views give: (N, C, 2) px.

    A camera cannot pull the point towards its own sighting. NaN if fewer than two other views agree.
    """
    views, rays = Views(cameras), rays_of(cameras, pixel)
    residual = np.full(pixel.shape, np.nan)
    for one in range(len(cameras)):
        others = found.used.copy()
        others[:, one] = False
        points = solved(views, rays, others, found.points)
        residual[:, one] = residuals(views, points, pixel)[:, one]
    return residual


def limits(cameras: Sequence[Camera]) -> Array:
    """Largest error of a sighting that counts, in each camera: (C,) px."""
    return SHARE * np.array([max(camera.size) for camera in cameras], float)


def rays_of(cameras: Sequence[Camera], pixel: Array) -> Array:
    """Viewing directions of the sightings: (N, C, 2) px -> (N, C, 3), NaN if not seen."""
    rays = np.full((*pixel.shape[:2], 3), np.nan)
    for number, camera in enumerate(cameras):
        seen = np.isfinite(pixel[:, number]).all(axis=1)
        rays[seen, number] = ray(camera, pixel[seen, number])
    return rays


def residuals(views: Views, points: Array, pixel: Array) -> Array:
    """Seen minus expected: (N, 3) m, (N, C, 2) px -> (N, C, 2) px; NaN if not seen or behind."""
    return np.asarray(pixel - views.project_local(views.local(points)).swapaxes(0, 1))


def error(residual: Array) -> Array:
    """Length of residuals: (..., 2) px -> (...,); infinite if there is none, so that no limit holds."""
    return np.nan_to_num(np.hypot(residual[..., 0], residual[..., 1]), nan=np.inf)


def solved(views: Views, rays: Array, used: Array, near: Array) -> Array:
    """Points nearest to the rays of the used views, for equal errors in px; NaN for fewer than two views.

    rays: (N, C, 3); used: (N, C) bool; near: (N, 3) m, approximate points, which give the depths.
    """
    enough = (used.sum(axis=1) >= 2) & np.isfinite(near).all(axis=1)
    points = np.full(near.shape, np.nan)
    if enough.any():
        centers = np.array([camera.center for camera in views.cameras])
        focal = np.array([camera.matrix[0, 0] for camera in views.cameras])
        distance = np.linalg.norm(near[enough, None] - centers, axis=2)
        weights = used[enough] * np.square(focal / distance)
        points[enough] = triangulate_views(centers, np.nan_to_num(rays[enough]), weights)
    return points


def _proposed(views: Views, rays: Array, pixel: Array, limit: Array) -> Array:
    """For each point the best proposal of any pair of views: (N, 3) m, NaN if no pair has one."""
    seen = np.isfinite(rays[..., 0])
    centers = np.array([camera.center for camera in views.cameras])
    best, points = np.full(len(pixel), np.inf), np.full((len(pixel), 3), np.nan)
    for i, j in combinations(range(len(views.cameras)), 2):
        rows = np.flatnonzero(seen[:, i] & seen[:, j])
        proposal = triangulate_pairs(centers[None, [i, j]], rays[rows][:, [i, j]])
        strain = error(residuals(views, proposal, pixel[rows])) / limit
        cost = (np.minimum(strain, 1.0) ** 2 * seen[rows]).sum(axis=1)
        better = cost < best[rows]
        best[rows[better]], points[rows[better]] = cost[better], proposal[better]
    return points
