"""Features of a window for the trees: the channels of Dollár et al. 2014, each averaged over cells of 4 px.

Brightness, two ratios of colours, likeness to skin, strength of the gradient, and its parts by orientation.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.cells import colours
from followspot_persons.hog.window import HEIGHT, WIDTH

CELLS = (WIDTH // 4, HEIGHT // 4)
"""Cells across and down."""
ORIENTATIONS = 6
CHANNELS = (5 + ORIENTATIONS) * CELLS[0] * CELLS[1]
"""Number of features of a window."""
ROOT = np.sqrt(np.arange(256, dtype=np.float32))
"""Square root of grey levels, of which gradients are taken: as strong in shadow as in light."""
NEIGHBOURHOOD, NOISE = 21, 0.2
"""Gradients are relative to the mean strength in a square of so many px, and so much more."""
DIFFERENCE = np.array([[-1, 0, 1]], np.float32)


CELL = (np.arange(HEIGHT)[:, None] // 4 * CELLS[0] + np.arange(WIDTH) // 4).ravel()
"""Number of the cell of each pixel."""


def channels(windows: Array | Sequence[Array]) -> Array:
    """Features of windows: (N, HEIGHT, WIDTH, 3) u8 -> (N, CHANNELS) f4."""
    described = np.empty((len(windows), CHANNELS), np.float32)
    for row, window in zip(described, windows, strict=True):
        strength, angle = _gradient(window)
        maps = [*colours(window), strength]
        cells = [cv2.resize(m, CELLS, interpolation=cv2.INTER_AREA).ravel() for m in maps]
        row[:] = np.concatenate([*cells, _histograms(strength.ravel(), angle.ravel())])
    return described


def _gradient(window: Array) -> tuple[Array, Array]:
    """Strength of the strongest colour's gradient, and its direction, 0 to 2 pi."""
    pixels = ROOT[window]
    across = cv2.split(cv2.filter2D(pixels, -1, DIFFERENCE, borderType=cv2.BORDER_REPLICATE))
    down = cv2.split(cv2.filter2D(pixels, -1, DIFFERENCE.T, borderType=cv2.BORDER_REPLICATE))
    x, y, most = across[0], down[0], across[0] ** 2 + down[0] ** 2
    for other_x, other_y in zip(across[1:], down[1:], strict=True):
        squared = other_x**2 + other_y**2
        stronger = squared > most
        x, y = np.where(stronger, other_x, x), np.where(stronger, other_y, y)
        most = np.maximum(most, squared)
    strength, angle = cv2.cartToPolar(x, y)
    return np.asarray(strength / (cv2.blur(strength, (NEIGHBOURHOOD, NEIGHBOURHOOD)) + NOISE)), angle


def _histograms(strength: Array, angle: Array) -> Array:
    """Mean strength in each cell along each orientation; what lies between two counts for both in part."""
    place = angle * np.float32(ORIENTATIONS / np.pi)
    below = place.astype(np.intp)
    share = (place - below) * strength
    cells = CELLS[0] * CELLS[1]
    bins = [below % ORIENTATIONS * cells + CELL, (below + 1) % ORIENTATIONS * cells + CELL]
    parts = [strength - share, share]
    sums = np.bincount(np.concatenate(bins), np.concatenate(parts), ORIENTATIONS * cells)
    return sums * (cells / len(CELL))
