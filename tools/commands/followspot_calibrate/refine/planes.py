"""Planes that keep their places in the pictures when the cameras change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.planes.fit import total_least_squares
from followspot_calibrate.similarity import on_a_line
from followspot_calibrate.triangulation import triangulate


def as_seen(
    planes: Mapping[str, Array], before: Sequence[Camera], after: Sequence[Camera], points: Array
) -> dict[str, Array]:
    """Each plane, (4,) m, as other cameras see it in the same pixels.

    points: (N, 3) m; their feet on the plane stand for its marks. A plane that no two cameras see stays.
    """
    known = points[np.isfinite(points).all(axis=1)]
    return {name: _as_seen(plane, before, after, known) for name, plane in planes.items()}


def _as_seen(plane: Array, before: Sequence[Camera], after: Sequence[Camera], points: Array) -> Array:
    feet = points - np.outer(points @ plane[:3] + plane[3], plane[:3])
    found = triangulate(after, np.stack([_pixels(camera, feet) for camera in before], axis=1)).points
    found = found[np.isfinite(found).all(axis=1)]
    if on_a_line(found):
        return plane
    new = total_least_squares(found)
    return new if new[:3] @ plane[:3] > 0 else -new


def _pixels(camera: Camera, points: Array) -> Array:
    """Images of points, (N, 2) px; NaN outside the picture."""
    pixel = project(camera, points)
    outside = np.any((pixel < 0) | (pixel > np.array(camera.size) - 1), axis=1, keepdims=True)
    return np.where(outside, np.nan, pixel)
