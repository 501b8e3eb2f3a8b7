"""Features of a window for the network: gradients, brightness and skin, in cells.

Coarse cells of 8 px cover the window, fine ones of 4 px the head, where front and back differ. Hue takes no
part but for the likeness to skin, for clothes and hair have any colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.window import HEIGHT, WIDTH, descriptor

HEAD = (slice(2, 34), slice(16, 48))
"""Rows and columns of the head in the window, px."""
COARSE, FINE = (WIDTH // 8, HEIGHT // 8), (8, 8)
"""Cells across and down."""
CELL_FEATURES = 9 * (COARSE[0] * COARSE[1] + FINE[0] * FINE[1]) + 2 * (
    COARSE[0] * COARSE[1] + FINE[0] * FINE[1]
)
"""Number of features of a window."""
LOGARITHM = np.log(np.arange(256, dtype=np.float32) + 8)
"""Offset of the logarithm of grey levels, which suppresses noise in the dark."""
SKIN = ((0.35, 0.2), (0.2, 0.15))
"""log(red / green) and log(green / blue) of skin, light to dark: mean and standard deviation."""


def cell_features(windows: Array | Sequence[Array]) -> Array:
    """Features of windows: (N, HEIGHT, WIDTH, 3) u8 -> (N, CELL_FEATURES) f4."""
    described = np.empty((len(windows), CELL_FEATURES), np.float32)
    for row, window in zip(described, windows, strict=True):
        row[:] = np.concatenate([*_edges(window), *_coloured_cells(window)])
    return described


def _edges(window: Array) -> tuple[Array, Array]:
    """Histograms of the coarse and of the fine cells."""
    head = np.ascontiguousarray(window[HEAD])
    return (
        _unblocked(np.asarray(descriptor().compute(window)), COARSE),
        _unblocked(np.asarray(_head_descriptor().compute(head)), FINE),
    )


@cache
def _head_descriptor() -> cv2.HOGDescriptor:
    return cv2.HOGDescriptor((32, 32), (8, 8), (4, 4), (4, 4), 9)


def _unblocked(blocks: Array, cells: tuple[int, int]) -> Array:
    """One histogram a cell: the sum of those of the blocks that it is part of, each normalised for itself."""
    across, down = cells
    blocks = blocks.reshape(across - 1, down - 1, 2, 2, 9)
    histograms = np.zeros((across, down, 9), np.float32)
    for right in (0, 1):
        for below in (0, 1):
            histograms[right : right + across - 1, below : below + down - 1] += blocks[:, :, right, below]
    return histograms.ravel()


def _coloured_cells(window: Array) -> list[Array]:
    """Brightness over that of the body, as a logarithm, and likeness to skin, of coarse and fine cells."""
    brightness, _, _, likeness = colours(window)
    maps = (brightness, likeness)
    coarse = [cv2.resize(m, COARSE, interpolation=cv2.INTER_AREA).ravel() for m in maps]
    fine = [cv2.resize(m[HEAD], FINE, interpolation=cv2.INTER_AREA).ravel() for m in maps]
    return coarse + fine


def colours(window: Array) -> tuple[Array, Array, Array, Array]:
    """Logarithms of brightness over the body's, of red over green, of green over blue; likeness to skin.

    window: (H, W, 3) u8 BGR. Returns (H, W) f4 each.
    """
    blue, green, red = cv2.split(LOGARITHM[window])
    brightness = (blue + green + red) / 3
    brightness -= brightness[4:-4, 12:-12].mean()
    red_green, green_blue = red - green, green - blue
    return brightness, red_green, green_blue, _skin(red_green, green_blue)


def _skin(red_green: Array, green_blue: Array) -> Array:
    """Likeness to skin, 0 to 1, from log(red / green) and log(green / blue)."""
    (mean_rg, sigma_rg), (mean_gb, sigma_gb) = SKIN
    squared = ((red_green - mean_rg) / sigma_rg) ** 2 + ((green_blue - mean_gb) / sigma_gb) ** 2
    return np.asarray(np.exp(np.float32(-0.5) * squared))
