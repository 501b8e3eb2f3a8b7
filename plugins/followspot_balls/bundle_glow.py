"""The light that a glowing ball throws on what it lies on draws its centre there, in colour cameras only.

Near a plane it is by up to 2 cm and the same for all colour cameras, so they agree on a wrong place.
Infrared cameras do not see the light: with the offset as an unknown, they settle the place.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def nearest_planes(planes: Array, xyz: Array, radius: Array) -> tuple[Array, Array]:
    """Normals (M, 3) of the planes nearest to balls, and the balls' clearances (M,) m; inf without planes.

    planes: (N, 4); xyz: (M, 3) m; radius: (M,) m.
    """
    if not len(planes):
        return np.zeros(xyz.shape), np.full(len(xyz), np.inf)
    distance = np.abs(xyz @ planes[:, :3].T + planes[:, 3])
    nearest = distance.argmin(axis=1)
    clearance = distance[np.arange(len(xyz)), nearest] - radius
    return planes[nearest, :3], np.maximum(clearance, 0.0)


def glow_sigma(clearance: Array, touching: float, reach: float) -> Array:
    """One sigma of the offset, m: `touching` for a ball that touches the plane, falling off with `reach`."""
    return np.asarray(touching * np.exp(-clearance / reach))
