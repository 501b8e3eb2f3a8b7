"""Cameras that a good calibration leaves slightly off, and targets that are carried before them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tests.tools.calibrate.rooms import made_room

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.adjust import Free
from followspot_calibrate.adjust.projection import moved

FLOOR = {"floor": np.array([0.0, 0.0, 1.0, 0.0])}
RADIUS = 0.0762
TRUE = made_room(6, 1).cameras


def off(cameras: Sequence[Camera], seed: int = 1) -> list[Camera]:
    """As a good calibration leaves them: 3 mm, 0.05 degrees, 0.1 % of fy, 0.3 px of the middle (sigma)."""
    random = np.random.default_rng(seed)
    free = Free(aspect=True, center=True)
    sigma = np.array([np.radians(0.05)] * 3 + [0.003] * 3 + [0.001] + [0.3] * 2)
    return [moved(camera, sigma * random.normal(size=9), free) for camera in cameras]


def carried(rows: int = 600, noise: float = 0.2) -> tuple[Array, Array]:
    """Places of targets, (N, 3) m, and what the true cameras see: (N, C, 2) px."""
    random = np.random.default_rng(0)
    points = random.uniform([-1.5, -1.5, 0.3], [1.5, 1.5, 2.0], (rows, 3))
    pixel = np.stack([project(camera, points) for camera in TRUE], axis=1)
    return points, pixel + noise * random.normal(size=pixel.shape)
