"""Panoramas whose last column meets the first."""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera


def full_turn(camera: Camera) -> bool:
    """Whether the picture shows the whole horizon, to within a pixel."""
    circumference = 2 * np.pi * camera.matrix[0, 0]
    return camera.model == "cylinder" and bool(abs(circumference - camera.size[0]) < 1)


def turn_of(camera: Camera) -> int:
    """Columns of a full turn; 0 for a picture with borders."""
    return camera.size[0] if full_turn(camera) else 0


def short_way(apart: Array, turn: float) -> Array:
    """Differences of columns the short way round, px; turn: columns of a full turn, 0 for none."""
    return np.asarray(apart - turn * np.rint(apart / turn)) if turn else apart
