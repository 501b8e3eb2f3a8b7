"""From light to a picture: gamma, noise, hot pixels."""

from __future__ import annotations

import zlib

import cv2
import numpy as np

from followspot import Array

GAMMA = 0.78
"""Exponent of the colour cameras; infrared cameras are linear."""
POOL = 48
"""By how many pixels the noise can be shifted along each axis."""
HOT = 4
"""Number of hot pixels of a camera."""


def linear(color: Array) -> Array:
    """Light that a colour camera shows as this value, both 0 to 255."""
    return np.asarray(255.0 * (np.asarray(color, float) / 255.0) ** (1 / GAMMA))


def displayed(light: Array) -> Array:
    """A colour camera's values for this light, both 0 to 255; the inverse of :func:`linear`."""
    return np.asarray(255.0 * (np.asarray(light, float) / 255.0) ** GAMMA)


DISPLAYED = np.round(displayed(np.arange(256))).astype(np.uint8)
"""The same for uint8, as a table."""


def own_rng(seed: int, camera: str) -> np.random.Generator:
    """Random numbers that belong to one camera, the same in every process."""
    return np.random.default_rng([seed, zlib.crc32(camera.encode())])


class Sensor:
    """One camera's sensor. Noise is drawn once and shifted by a random offset in each frame."""

    def __init__(self, shape: tuple[int, int, int], noise: float, rng: np.random.Generator) -> None:
        """shape: (H, W, C) of the picture; noise: standard deviation, grey levels."""
        height, width, channels = shape
        grain = np.round(rng.normal(0.0, noise, (height + POOL, width + POOL, channels)))
        self._brighter = np.maximum(grain, 0).clip(0, 255).astype(np.uint8).squeeze()
        self._darker = np.maximum(-grain, 0).clip(0, 255).astype(np.uint8).squeeze()
        self._hot = (rng.integers(0, height, HOT), rng.integers(0, width, HOT))
        self._heat = rng.integers(80, 255, HOT).astype(np.uint8)[:, None]
        self._seed = int(rng.integers(1 << 31))
        self._shape = shape

    def expose(self, picture: Array, frame: int, out: Array) -> None:
        """Picture without noise, (H, W) or (H, W, 3) uint8, which is spoilt, with noise into `out`."""
        height, width, _ = self._shape
        down, right = ((self._seed + frame) * step % 1000003 % POOL for step in (7919, 104729))
        window = (slice(down, down + height), slice(right, right + width))
        cv2.add(picture, self._brighter[window], dst=picture)
        cv2.subtract(picture, self._darker[window], dst=out.reshape(picture.shape))
        out[self._hot] = self._heat
