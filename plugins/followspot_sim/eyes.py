"""Cameras side by side, so that one computation serves all cameras of a process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera

REACH = {"color": 2.0, "infrared": 1.1}
"""How many radii of a ball are drawn; colour cameras see it glow."""


@dataclass(frozen=True, eq=False)
class Eyes:
    """V cameras; what belongs to pixels stands in one row, one camera's pixels after the other's.

    center: (V, 3) m; axis: (V, 3) unit vectors ahead; focal: (V,) px; size: (V, 2) width and height, px;
    reach: (V,) radii; first: (V,) where each camera's pixels begin; rays: (3, N) float32, unit vectors;
    pitch: (N,) angle between neighbouring rays, rad.
    """

    cameras: tuple[Camera, ...]
    center: Array
    axis: Array
    focal: Array
    size: Array
    reach: Array
    first: Array
    rays: Array
    pitch: Array


def eyes_of(cameras: Sequence[tuple[Camera, Array]]) -> Eyes:
    """The eyes of at least one camera, each with the rays of its pixels, (H, W, 3) float32."""
    alone, rays = zip(*cameras, strict=True)
    return Eyes(
        cameras=alone,
        center=np.array([c.center for c in alone]),
        axis=np.array([c.rotation[2] for c in alone]),
        focal=np.array([c.matrix[0, 0] for c in alone]),
        size=np.array([c.size for c in alone]),
        reach=np.array([REACH[c.kind] for c in alone]),
        first=np.cumsum([0] + [r.size // 3 for r in rays[:-1]]),
        rays=np.ascontiguousarray(np.concatenate([r.reshape(-1, 3) for r in rays]).T),
        pitch=np.concatenate([_pitch(r).ravel() for r in rays]),
    )


def _pitch(rays: Array) -> Array:
    """Mean angle between neighbouring rays of (H, W, 3), (H, W) rad."""
    down, right = (np.sqrt(np.square(step).sum(axis=2)) for step in np.gradient(rays, axis=(0, 1)))
    return np.asarray(np.sqrt(down * right))
