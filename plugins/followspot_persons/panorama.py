"""Panoramas whose last column meets the first."""

from __future__ import annotations

import numpy as np

from followspot import Camera


def full_turn(camera: Camera) -> bool:
    """Whether the picture shows the whole horizon, to within a pixel."""
    circumference = 2 * np.pi * camera.matrix[0, 0]
    return camera.model == "cylinder" and bool(abs(circumference - camera.size[0]) < 1)
