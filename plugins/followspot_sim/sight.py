"""Lines of sight among capsules: what stands between a camera and a ball.

A capsule is all points within `radius` of a segment; a ball is a capsule whose segment is a point.
"""

from __future__ import annotations

import numpy as np

from followspot import Array


def approach(origin: Array, rays: Array, ends: Array) -> tuple[Array, Array]:
    """How near rays come to segments: distance (N, K) m, and how far along the ray that is (N, K) m.

    origin: (3,) m; rays: (N, 3) unit vectors; ends: (K, 2, 3) m.
    """
    axis, start = ends[:, 1] - ends[:, 0], ends[:, 0] - origin
    along_axis, along_start = rays @ axis.T, rays @ start.T
    across = np.maximum(np.einsum("kj,kj->k", axis, axis) - along_axis**2, 1e-12)
    both = np.einsum("kj,kj->k", axis, start) - along_start * along_axis
    t = np.clip(-both / across, 0.0, 1.0)
    square = np.einsum("kj,kj->k", start, start) - along_start**2 + 2 * t * both + t * t * across
    return np.sqrt(np.maximum(square, 0.0)), along_start + t * along_axis


def blocked(origin: Array, rays: Array, surface: Array, ends: Array, radius: Array, soft: float) -> Array:
    """Share of each ray, 0 to 1, that meets a capsule before it has gone `surface` metres.

    surface: (N,) m; soft: width of the edge of a capsule, m (a pixel at the ball's distance).
    Returns (N,).
    """
    distance, along = approach(origin, rays, ends)
    entry = along - np.sqrt(np.maximum(radius**2 - distance**2, 0.0))
    share = np.clip(0.5 + (radius - distance) / soft, 0.0, 1.0) * (entry < surface[:, None])
    return np.asarray(share.max(axis=1, initial=0.0))


def disc(samples: int) -> Array:
    """Points that fill the unit disc evenly (sunflower), (samples, 2)."""
    k = np.arange(samples) + 0.5
    radius, angle = np.sqrt(k / samples), np.pi * (1 + np.sqrt(5)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
