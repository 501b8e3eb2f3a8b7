"""Lines of sight among capsules: what stands between a camera and a ball.

A capsule is all points within `radius` of a segment; a ball is a capsule whose segment is a point.
"""

from __future__ import annotations

import numpy as np

from followspot import Array


def approach(origin: Array, rays: Array, ends: Array) -> tuple[Array, Array]:
    """How near rays come to segments, (K, N) m, and how far along the ray that is, (K, N) m.

    origin: (3,) m; rays: (3, N), unit vectors; ends: (K, 2, 3) m.
    """
    start, axis = ends[:, 0] - origin, ends[:, 1] - ends[:, 0]
    fixed = np.stack([axis, start], axis=1) @ start[..., None]
    length = np.einsum("kj,kj->k", axis, axis)[:, None]
    along_axis, along_start = axis @ rays, start @ rays
    across = np.maximum(length - along_axis * along_axis, 1e-12)
    both = fixed[:, 0] - along_start * along_axis
    t = np.minimum(np.maximum(-both / across, 0.0), 1.0)
    square = fixed[:, 1] - along_start * along_start + t * (2 * both + t * across)
    return np.sqrt(np.maximum(square, 0.0)), along_start + t * along_axis


def blocked(
    origin: Array, rays: Array, surface: Array, ends: Array, radius: Array, soft: Array | float
) -> Array:
    """Share of each ray, 0 to 1, that meets a capsule before it has gone `surface` metres.

    rays: (3, N) unit vectors; surface: (N,) m; soft: width of the edge of a capsule, m (a pixel at
    the ball's distance) for all rays or each. Returns (N,).
    """
    distance, along = approach(origin, rays, ends)
    thick = radius[:, None]
    entry = along - np.sqrt(np.maximum(thick * thick - distance * distance, 0.0))
    share = np.minimum(np.maximum(0.5 + (thick - distance) / soft, 0.0), 1.0) * (entry < surface)
    return np.asarray(share.max(axis=0, initial=0.0))


def disc(samples: int) -> Array:
    """Points that fill the unit disc evenly (sunflower), (samples, 2)."""
    k = np.arange(samples) + 0.5
    radius, angle = np.sqrt(k / samples), np.pi * (1 + np.sqrt(5)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
