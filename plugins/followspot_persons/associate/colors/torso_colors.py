"""Colours of torsos as histograms: those of a person agree over time and between cameras.

Hue and saturation count where a pixel is neither grey nor dark, its brightness otherwise (Pérez, Hue,
Vermaak & Gangnet 2002, section 2.2). Two histograms are compared by their Hellinger distance.
"""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array

HUES, SATURATIONS, VALUES = 8, 3, 6
BINS = HUES * SATURATIONS + VALUES
GRAY, DARK = 40, 40
"""Saturation and brightness, 0 to 255, below which a pixel's hue is noise."""
INSIDE = 0.5
"""Share of a torso that must be in the picture."""
SAME = 3.0
"""Rate at which the density of squared distances falls between pictures of one person; those of different
people are spread evenly over 0 to 1. The mean of one person in one camera of the development recording `d_m`
is 0.31, over cameras 0.43, of two people 0.97.
"""
UPPER, LOWER, SIDES = 0.2, 0.5, 0.3
"""Part of the box of a whole body that shows the torso: rows from above; what is left out at each side."""
_DOWN, _ACROSS = (part.ravel() for part in np.meshgrid(*[(np.arange(8) + 1) / 9] * 2, indexing="ij"))
_CORNERS = np.column_stack(
    [(1 - _DOWN) * (1 - _ACROSS), (1 - _DOWN) * _ACROSS, _DOWN * (1 - _ACROSS), _DOWN * _ACROSS]
)
"""(K, 4) weights of the corners in each point of the grid."""


def histograms(pixels: Array, corners: Array) -> Array:
    """Histograms (N, BINS) of patches, each of sum 1; NaN for patches that are not enough in the picture.

    pixels: (H, W, 3) u1, blue, green, red; corners: (N, 4, 2) px, the two upper ones first, NaN if they are
    not known. What is in another patch, too, does not count, for either may hide the other.
    """
    grid = np.einsum("kc,ncd->nkd", _CORNERS, corners)
    height, width = pixels.shape[:2]
    there = ((grid > -0.5) & (grid < [width - 0.5, height - 0.5])).all(axis=-1) & ~_shared(grid, corners)
    column, row = np.rint(np.where(there[..., None], grid, 0)).astype(int).T
    bins = _bins(np.ascontiguousarray(pixels[row.T, column.T]))
    place = bins + BINS * np.arange(len(corners))[:, None]
    count = np.bincount(place[there], minlength=BINS * len(corners)).reshape(-1, BINS)
    total = count.sum(axis=1, keepdims=True)
    return np.asarray(np.where(total >= INSIDE * len(_CORNERS), count / np.maximum(total, 1), np.nan))


def _shared(grid: Array, corners: Array) -> Array:
    """Whether points (N, K, 2) of patches lie in the upright box about another one, (N, K)."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    inside = ((grid[:, :, None] >= low) & (grid[:, :, None] <= high)).all(axis=-1)
    return np.asarray((inside & ~np.eye(len(corners), dtype=bool)[:, None]).any(axis=2))


def _bins(colors: Array) -> Array:
    """Bin of each colour, (N, K, 3) u1 -> (N, K)."""
    if not colors.size:
        return np.zeros(colors.shape[:2], int)
    hue, saturation, value = np.moveaxis(
        np.asarray(cv2.cvtColor(colors, cv2.COLOR_BGR2HSV)).astype(int), -1, 0
    )
    colored = (hue * HUES // 180) * SATURATIONS + (saturation - GRAY) * SATURATIONS // (256 - GRAY)
    plain = HUES * SATURATIONS + value * VALUES // 256
    return np.asarray(np.where((saturation >= GRAY) & (value >= DARK), colored, plain))


def torsos(joints: tuple[str, ...], pixel: Array) -> Array:
    """Corners (N, 4, 2) px of torsos: shoulders and hips. pixel: (N, J, 2) px, NaN for joints not found."""
    names = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")
    if not set(names) <= set(joints):
        return np.full((len(pixel), 4, 2), np.nan)
    return np.asarray(pixel[:, [joints.index(name) for name in names]])


def torsos_in(box: Array) -> Array:
    """Corners (N, 4, 2) px of the torsos in boxes (N, 4) px of whole bodies."""
    low, size = box[:, :2], box[:, 2:] - box[:, :2]
    share = [[x, y] for y in (UPPER, LOWER) for x in (SIDES, 1 - SIDES)]
    return np.asarray(low[:, None] + size[:, None] * np.array(share))


def log_ratios(one: Array, other: Array) -> Array:
    """Log-likelihood ratios that histograms (..., BINS) are of one person against two; 0 if one is unknown.

    With d the squared distance, one person has the density SAME exp(-SAME d) / (1 - exp(-SAME)).
    """
    squared = 1 - np.sqrt(one * other).sum(axis=-1)
    ratio = np.log(SAME / (1 - np.exp(-SAME))) - SAME * squared
    return np.asarray(np.where(np.isfinite(ratio), ratio, 0.0))
