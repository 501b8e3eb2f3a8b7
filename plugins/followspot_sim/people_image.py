"""Limbs as convex outlines in the distorted picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.eyes import Eyes
from followspot_sim.outline import fixed_point, stadiums
from followspot_sim.sight import dot

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


def outlines(eyes: Eyes, pixel: Array, limbs: Array, radius: Array) -> list[Outlines]:
    """Outlines of limbs in the picture of each camera.

    pixel: (V, K, 2, 2) px, their ends in the pictures; limbs: (K, 2, 3) m; radius: (K,) m.
    """
    away = limbs - eyes.center[:, None, None]
    depth = dot(away, eyes.axis[:, None, None])
    scale = eyes.focal[:, None, None] / np.maximum(depth, NEAREST)
    width = scale * radius[:, None]
    outline = stadiums(pixel.reshape(-1, 2, 2), width.reshape(-1, 2))
    outline = outline.reshape(*depth.shape[:2], *outline.shape[1:])
    width = width.max(axis=2)[..., None]
    with np.errstate(invalid="ignore"):
        low, high = np.minimum(pixel[:, :, 0], pixel[:, :, 1]), np.maximum(pixel[:, :, 0], pixel[:, :, 1])
        inside = (high > -width) & (low - width < eyes.size[:, None]) & (high - low < LONGEST)
    shown = inside.all(axis=2) & (depth > NEAREST).all(axis=2)
    polygon = fixed_point(np.where(shown[:, :, None, None], outline, 0.0))
    middle = away[:, :, 0] + away[:, :, 1]
    order = np.argsort(-dot(middle, middle), axis=1, kind="stable")
    scale = (scale[..., 0] + scale[..., 1]) / 2
    return [
        Outlines(polygon[v], scale[v], shown[v], order[v][shown[v][order[v]]].tolist())
        for v in range(len(pixel))
    ]
