"""Viewing rays of the pixels of a camera, for rendering."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera

REACH = {"color": 2.0, "infrared": 1.1}
"""How many radii of a ball are drawn; colour cameras see it glow."""


@dataclass(frozen=True, eq=False)
class CameraRays:
    """One camera with the viewing rays of its W * H pixels, row after row.

    rays: (3, W * H) float32, unit vectors in the room; pitch: (W * H,) angle between neighbouring rays, rad.
    """

    camera: Camera
    rays: Array
    pitch: Array


def camera_rays(camera: Camera, rays: Array) -> CameraRays:
    """The rays of a camera, of which those of its pixels are (H, W, 3) unit vectors."""
    rays = rays.astype(np.float32)
    return CameraRays(camera, np.ascontiguousarray(rays.reshape(-1, 3).T), _pitch(rays).ravel())


def _pitch(rays: Array) -> Array:
    """Mean angle between neighbouring rays of (H, W, 3), (H, W) rad."""
    down, right = (np.sqrt(np.square(step).sum(axis=2)) for step in np.gradient(rays, axis=(0, 1)))
    return np.asarray(np.sqrt(down * right))
