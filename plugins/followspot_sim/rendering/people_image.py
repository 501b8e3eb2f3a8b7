"""Limbs as convex outlines in the distorted picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot_sim.rendering.outline import fixed_point, stadiums
from followspot_sim.rendering.ray_casting import dot

NEAREST = 0.3
"""Limbs nearer than this to the camera's plane are left out, m."""
LONGEST = 1000.0
"""So are longer ones, which the lens cannot mean, px."""


@dataclass(frozen=True, eq=False)
class Outlines:
    """Limbs in one picture.

    polygon: (K, 14, 2) as OpenCV draws it; scale: (K,) px/m; shown: (K,) bool; order: those shown,
    from far to near.
    """

    polygon: Array
    scale: Array
    shown: Array
    order: list[int]


def outlines(camera: Camera, pixel: Array, limbs: Array, radius: Array) -> Outlines:
    """Outlines of limbs in the picture of a camera.

    pixel: (K, 2, 2) px, their ends in the picture; limbs: (K, 2, 3) m; radius: (K,) m.
    """
    away = limbs - camera.center
    depth = dot(away, camera.rotation[2])
    scale = camera.matrix[0, 0] / np.maximum(depth, NEAREST)
    width = scale * radius[:, None]
    outline = stadiums(pixel, width)
    width = width.max(axis=1)[:, None]
    with np.errstate(invalid="ignore"):
        low, high = np.minimum(pixel[:, 0], pixel[:, 1]), np.maximum(pixel[:, 0], pixel[:, 1])
        inside = (high > -width) & (low - width < camera.size) & (high - low < LONGEST)
    shown = inside.all(axis=1) & (depth > NEAREST).all(axis=1)
    polygon = fixed_point(np.where(shown[:, None, None], outline, 0.0))
    middle = away[:, 0] + away[:, 1]
    order = np.argsort(-dot(middle, middle), kind="stable")
    return Outlines(polygon, (scale[:, 0] + scale[:, 1]) / 2, shown, order[shown[order]].tolist())
