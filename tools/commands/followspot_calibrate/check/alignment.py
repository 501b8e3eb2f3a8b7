"""The similarity that lays one calibration on another of the same cameras."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.similarity import Similarity, similarity, spread

ROUNDS = 10
FAR = 2.0
"""Distance of a camera from its counterpart, over the median distance, from which it has no say."""


def aligned(here: Sequence[Camera], there: Sequence[Camera]) -> Similarity:
    """The similarity from there to here that most cameras agree with.

    Each camera stands for its centre and three points beside, below and before it, as far away as the cameras
    are from each other: so two cameras suffice, and places and directions count alike.
    """
    size = _size(here)
    scale, agree = size / _size(there), np.ones(len(here), bool)
    target = np.array([landmarks(camera, size) for camera in here])
    for _ in range(ROUNDS):
        source = np.array([landmarks(camera, size / scale) for camera in there])
        found = similarity(source[agree].reshape(-1, 3), target[agree].reshape(-1, 3))
        away = np.linalg.norm(found.points(source) - target, axis=2).mean(axis=1)
        agree = away <= max(FAR * float(np.median(away)), 1e-9 * size)
        scale = found.scale
    return found


def landmarks(camera: Camera, size: float) -> Array:
    """The centre, and the points one size along each axis of the camera: (4, 3) m."""
    return camera.center + size * np.vstack([np.zeros(3), camera.rotation])


def _size(cameras: Sequence[Camera]) -> float:
    """Distance between the cameras, m; 1 if all have one centre."""
    return spread([camera.center for camera in cameras]) or 1.0
