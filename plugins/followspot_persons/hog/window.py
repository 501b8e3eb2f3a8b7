"""The detector's window: a head and torso of fixed size, and its histograms of oriented gradients.

Histograms as Dalal & Triggs 2005: cells of 8 x 8 px, blocks of 2 x 2 cells, 9 unsigned orientations, L2-Hys.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from followspot import Array

WIDTH, HEIGHT = 64, 80
"""px."""
BODY = np.array([8.0, 6.0, 56.0, 78.0])
"""Position of the upper body in the window, head top to waist: x0, y0, x1, y1, px."""
TALL = BODY[3] - BODY[1]
"""Height of the upper body in the window, px."""


@dataclass(frozen=True)
class Layout:
    """A window, and where it has the upper body: in the middle of its columns, px."""

    width: int
    height: int
    top: float
    """Row of the head's top."""
    tall: float
    """From there to the waist."""


UPPER = Layout(WIDTH, HEIGHT, float(BODY[1]), float(TALL))
"""Head and torso alone."""
STRIDE = 8
"""Step of the windows of a search, px: one cell."""
ABOVE = 32
"""Largest part of a window above the picture, where the border is repeated, px of the window."""
FEATURES = 2268
"""Number of features of a window."""


@cache
def descriptor() -> cv2.HOGDescriptor:
    """Computes the histograms of a window."""
    return _hog()


def detector(weights: Array) -> cv2.HOGDescriptor:
    """Searches pictures with linear weights, (FEATURES + 1,) f4, the bias last."""
    hog = _hog()
    hog.setSVMDetector(weights)
    return hog


def _hog() -> cv2.HOGDescriptor:
    return cv2.HOGDescriptor((WIDTH, HEIGHT), (16, 16), (STRIDE, STRIDE), (8, 8), 9)


def describe(windows: Array | Sequence[Array]) -> Array:
    """Histograms of windows: (N, HEIGHT, WIDTH, 3) u8 -> (N, FEATURES) f4."""
    hog = descriptor()
    features = np.empty((len(windows), FEATURES), np.float32)
    for row, window in zip(features, windows, strict=True):
        row[:] = np.ravel(hog.compute(window))
    return features


def cut(pixels: Array, box: Array, margin: float = 0.0, layout: Layout = UPPER) -> Array:
    """The part of a picture that shows a box where the window has its upper body, in the size of the window.

    Beyond the picture's edge its border is repeated. pixels: (H, W, 3) u8; box: x0, y0, x1, y1, px, of which
    the height and the middle column count; margin: of the window on each side, px; layout: of the window.
    Returns (height + 2 margin, width + 2 margin, 3) u8.
    """
    scale = (box[3] - box[1]) / layout.tall
    left = (box[0] + box[2]) / 2 - scale * (layout.width / 2 + margin)
    top = box[1] - scale * (layout.top + margin)
    size = (round(layout.width + 2 * margin), round(layout.height + 2 * margin))
    # Edges of pixels map to edges of pixels: the centre of the first stands half a pixel within.
    half = (scale - 1) / 2
    place = np.array([[scale, 0, left + half], [0, scale, top + half]])
    if scale > 1.5:  # what a pixel of the window covers is averaged, not sampled
        pixels, place = _shrunk(pixels, place, scale, size)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(pixels, place, size, flags=flags, borderMode=cv2.BORDER_REPLICATE))


def _shrunk(pixels: Array, place: Array, scale: float, size: tuple[int, int]) -> tuple[Array, Array]:
    """The neighbourhood of the window in a smaller picture, and the window's place in it."""
    height, width = pixels.shape[:2]
    low = np.clip(np.floor(place[:, 2]).astype(int) - 2, 0, [width - 2, height - 2])
    high = np.ceil(place[:, 2] + scale * np.array(size)).astype(int) + 3
    high = np.clip(high, low + 2, [width, height])
    part = pixels[low[1] : high[1], low[0] : high[0]]
    smaller = np.maximum(1, np.rint((high - low) / scale)).astype(int)
    ratio = smaller / (high - low)
    resized = cv2.resize(part, smaller.tolist(), interpolation=cv2.INTER_AREA)
    moved = place.copy()
    moved[:, :2] *= ratio[:, None]
    moved[:, 2] = (place[:, 2] - low + 0.5) * ratio - 0.5
    return np.asarray(resized), moved
