"""Selection and weights of sightings of tracked targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.target_sightings import TargetSightings
from followspot_calibrate.triangulation import triangulate

LIT = 2.0
"""Distance of a target's middle from a plane below which it lights the plane, over its radius."""
CELL = 0.2
"""One sighting counts in each cube of that side, m: a target that lies still says one thing many times."""

OFF_MIDDLE = 0.04
"""Distance of a tracked sighting from the middle of its target, one sigma over its width. People hide
parts of the target and lamps are not in its middle, and that stays alike for a while."""


def select_sightings(
    cameras: Sequence[Camera], pixel: Array, radius: Array, planes: Mapping[str, Array]
) -> TargetSightings:
    """The rows to refine cameras with; a sighting that misleads is NaN there.

    pixel: (M, C, 2) px; radius: (M,) m, of the target of each row. Colour cameras see a target that lies on
    a plane together with the light that it throws on it, so these sightings do not count.
    """
    points = triangulate(cameras, pixel).points
    pixel = pixel.copy()
    color = np.array([camera.kind == "color" for camera in cameras])
    for plane in planes.values():
        near = np.abs(points @ plane[:3] + plane[3]) < LIT * radius
        pixel[near[:, None] & color] = np.nan
    views = np.isfinite(pixel[..., 0]).sum(axis=1)
    rows = np.flatnonzero(np.isfinite(points[:, 0]) & (views >= 2))
    rows = rows[np.argsort(-views[rows], kind="stable")]
    cells = np.round(points[rows] / CELL).astype(np.int64)
    first = np.unique(cells, axis=0, return_index=True)[1]
    chosen = rows[np.sort(first)]
    sigma = OFF_MIDDLE * widths(cameras, points[chosen], radius[chosen])
    return TargetSightings(pixel[chosen], sigma)


def concatenated(some: TargetSightings, others: TargetSightings | None) -> TargetSightings:
    """The rows of both."""
    if others is None:
        return some
    return TargetSightings(
        np.concatenate([some.pixel, others.pixel]), np.concatenate([some.sigma, others.sigma])
    )


def widths(cameras: Sequence[Camera], points: Array, radius: Array) -> Array:
    """Mean width of targets in the pictures: (N, 3) m, (N,) m -> (N,) px."""
    away = [np.linalg.norm(points - camera.center, axis=1) / camera.matrix[0, 0] for camera in cameras]
    return np.asarray((2 * radius / np.array(away)).mean(axis=0))
