"""The empty room as a depth camera sees it: rendered from the planes of the room, or learnt."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from followspot.messages import Array
from followspot_balls.depth.spheres import Lens

GRAZING = 1e-6
"""Smallest cosine of the angle between a ray and the normal of a plane that the ray meets."""


def rendered(lens: Lens, planes: Iterable[Array]) -> Array:
    """Depth of the nearest plane in each pixel, (H, W) float32 m; infinite if no plane covers the pixel.

    planes: (4,) each, m.
    """
    nearest = np.full(lens.stretch.shape, np.inf, np.float32)
    for plane in planes:
        height = float(plane[:3] @ lens.center + plane[3])
        closing = -(lens.rays @ plane[:3]) * np.sign(height)
        depth = np.divide(abs(height), closing, out=np.full(closing.shape, np.inf), where=closing > GRAZING)
        np.minimum(nearest, depth, out=nearest)
    return nearest


def learnt(background: Array, depth: Array) -> Array:
    """The background with one more depth image: the farthest depth that each pixel ever measured.

    background: (H, W) float32 m, 0 for pixels that measured nothing yet.
    """
    return np.fmax(background, depth)


def foreground(depth: Array, background: Array, clearance: float) -> Array:
    """What is nearer than the background by a clearance (m): (H, W) bool. What was not measured is not."""
    return np.asarray((depth > 0) & (depth < background - np.float32(clearance)))
