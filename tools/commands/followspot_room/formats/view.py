"""Cameras with rotated pictures, such as portrait videos."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot.room import Camera

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Clockwise rotation in a picture with y down: x to the right becomes y down."""


def turned_clockwise(camera: Camera, quarters: int) -> Camera:
    """The pinhole camera, without skew, of the picture turned clockwise by quarter turns.

    Pixel (x, y) of a picture of height h goes to (h - 1 - y, x).
    """
    for _ in range(quarters % 4):
        camera = _quarter(camera)
    return camera


def _quarter(camera: Camera) -> Camera:
    width, height = camera.size
    K = camera.matrix
    k1, k2, p1, p2, k3 = camera.distortion
    return replace(
        camera,
        size=(height, width),
        matrix=np.array([[K[1, 1], 0.0, height - 1 - K[1, 2]], [0.0, K[0, 0], K[0, 2]], [0.0, 0.0, 1.0]]),
        distortion=np.array([k1, k2, p2, -p1, k3]),
        rotation=QUARTER @ camera.rotation,
        translation=QUARTER @ camera.translation,
    )
