"""The height of a person whose upper body fills a box: people stand on the floor, z = 0."""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera
from followspot.geometry import ray

WAIST = 0.615
"""Height at which boxes of upper bodies end, over that of the person: the median of the detector's boxes."""
LOWEST = 0.2
"""A camera lower than this above z = 0 does not know its floor, m."""


def knows_floor(camera: Camera) -> bool:
    """Whether the camera's position gives people's heights; a camera at the origin was never placed."""
    return bool(camera.center[2] > LOWEST)


def standing(camera: Camera, box: Array) -> tuple[Array, Array]:
    """Horizontal distance and height of upright persons, (N,) m each, whose head tops and waists are given.

    With z the camera's height and a, b the rise per metre of the rays to head top and waist, the height is
    h = z + r a and the waist's WAIST h = z + r b, hence r = z (1 - WAIST) / (WAIST a - b). Both are NaN if no
    distance fits. box: (N, 4) px, x0, y0, x1, y1; columns beyond a panorama's width go on at 0.
    """
    middle = (box[:, 0] + box[:, 2]) / 2
    high = camera.center[2]
    top = rise(camera, middle, box[:, 1])
    waist = rise(camera, middle, box[:, 3])
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = high * (1 - WAIST) / (WAIST * top - waist)
    distance = np.where(distance > 0, distance, np.nan)
    return distance, high + distance * top


def rise(camera: Camera, x: Array, y: Array) -> Array:
    """Rise of the ray to a pixel per metre of horizontal distance."""
    direction = ray(camera, np.column_stack([x, y]))
    with np.errstate(divide="ignore"):
        return np.asarray(direction[:, 2] / np.hypot(direction[:, 0], direction[:, 1]))
