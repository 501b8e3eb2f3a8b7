"""Features of a window for the trees: the channels of Dollár et al. 2014, each averaged over cells of 4 px.

Brightness, two ratios of colours, likeness to skin, strength of the gradient, and its parts by orientation.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.cells import colours
from followspot_persons.hog.window import HEIGHT, WIDTH

CELL = 4
"""Side of a cell, px."""
CELLS = (WIDTH // CELL, HEIGHT // CELL)
"""Cells across and down."""
ORIENTATIONS = 6
MAPS = 5 + ORIENTATIONS
"""Number of channels."""
CHANNELS = MAPS * CELLS[0] * CELLS[1]
"""Number of features of a window of an upper body."""
ROOT = np.sqrt(np.arange(256, dtype=np.float32))
"""Square root of grey levels, of which gradients are taken: as strong in shadow as in light."""
NEIGHBOURHOOD, NOISE = 21, 0.2
"""Gradients are relative to the mean strength in a square of so many px, and so much more."""
DIFFERENCE = np.array([[-1, 0, 1]], np.float32)


def channels(windows: Array | Sequence[Array]) -> Array:
    """Features of windows of one size: (N, H, W, 3) u8, sides in whole cells -> (N, D) f4.

    D is CHANNELS for windows of HEIGHT x WIDTH.
    """
    height, width = windows[0].shape[:2] if len(windows) else (HEIGHT, WIDTH)
    described = np.empty((len(windows), MAPS * (height // CELL) * (width // CELL)), np.float32)
    for row, window in zip(described, windows, strict=True):
        row[:] = _of(window)
    return described


def _of(window: Array) -> Array:
    cells = window.shape[1] // CELL, window.shape[0] // CELL
    strength, angle = _gradient(window)
    maps = [*colours(window), strength]
    means = [cv2.resize(m, cells, interpolation=cv2.INTER_AREA).ravel() for m in maps]
    return np.concatenate([*means, _histograms(strength, angle, cells)])


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


def _histograms(strength: Array, angle: Array, cells: tuple[int, int]) -> Array:
    """Mean strength in each cell along each orientation; orientations between two count for both in part."""
    strength, place = strength.ravel(), angle.ravel() * np.float32(ORIENTATIONS / np.pi)
    below = place.astype(np.intp)
    share = (place - below) * strength
    number, count = _numbers(cells), cells[0] * cells[1]
    bins = [below % ORIENTATIONS * count + number, (below + 1) % ORIENTATIONS * count + number]
    parts = [strength - share, share]
    sums = np.bincount(np.concatenate(bins), np.concatenate(parts), ORIENTATIONS * count)
    return sums / CELL**2


@cache
def _numbers(cells: tuple[int, int]) -> Array:
    """Number of the cell of each pixel, row by row."""
    across, down = cells
    return (np.arange(CELL * down)[:, None] // CELL * across + np.arange(CELL * across) // CELL).ravel()
