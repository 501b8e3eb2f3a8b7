"""How the images of a point in two cameras of a room relate: on epipolar lines, and over planes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.geometry import fundamental_matrix, plane_homography
from followspot.messages import Array
from followspot.room import Room


def fundamental_stack(room: Room) -> Array:
    """Fundamental matrices of all ordered pairs of cameras: (C, C, 3, 3); zero for a camera with itself."""
    P = [camera.projection for camera in room.cameras.values()]
    stack = np.zeros((len(P), len(P), 3, 3))
    for i, j in _ordered_pairs(P):
        stack[i, j] = fundamental_matrix(P[i], P[j])
    return stack


def homography_stack(room: Room) -> Array:
    """Homographies over each plane for all ordered pairs of cameras: (planes, C, C, 3, 3)."""
    cameras = list(room.cameras.values())
    stack = np.zeros((len(room.planes), len(cameras), len(cameras), 3, 3))
    for number, plane in enumerate(room.planes.values()):
        for i, j in _ordered_pairs(cameras):
            stack[number, i, j] = plane_homography(cameras[i], cameras[j], plane)
    return stack


def _ordered_pairs(items: Sequence[object]) -> list[tuple[int, int]]:
    return [(i, j) for i in range(len(items)) for j in range(len(items)) if i != j]
