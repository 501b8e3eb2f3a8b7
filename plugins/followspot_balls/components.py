"""Connected bright components of many small pictures at once, with sub-pixel centroids."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array

REACH = 9
"""Side of the square in which the local peak is sought, px: a ball is 5 to 9 px wide."""


class Components(NamedTuple):
    """One row for each component."""

    tile: Array
    """(N,) tile that it lies in."""
    center: Array
    """(N, 2) px within the tile, x and y."""
    area: Array
    """(N,) px."""
    clipped: Array
    """(N, 4) bool: touches the left, top, right, bottom of its tile."""
    label: Array
    """(P,) row of the component of each of its pixels."""
    index: Array
    """(P,) flat index of each pixel in the tiles."""


def cut(pixels: Array, corners: Array, height: int, width: int) -> Array:
    """Copy windows of a picture into a stack; black where they reach beyond it.

    pixels: (H, W, C); corners: (N, 2) int, x and y of the upper left pixel. Returns (N, height + 1,
    width, C), with an empty last row, so that the stack may be treated as one tall picture.
    """
    tiles = np.zeros((len(corners), height + 1, width, pixels.shape[2]), pixels.dtype)
    bottom, right = pixels.shape[:2]
    for tile, (x, y) in zip(tiles, corners.tolist(), strict=True):
        left, top = max(x, 0), max(y, 0)
        part = pixels[top : min(y + height, bottom), left : min(x + width, right)]
        tile[top - y : top - y + part.shape[0], left - x : left - x + part.shape[1]] = part
    return tiles


def above_local_peak(level: Array, fraction: float) -> Array:
    """Pixels above a fraction of the brightest one near them.

    A ball is cut from a dimmer projection or halo that it touches, whatever the exposure.
    level: (H, W) u8, 0 where nothing is sought. Returns (H, W) bool.
    """
    peak = cv2.dilate(level, np.ones((REACH, REACH), np.uint8))
    return np.asarray((level > 0) & (level >= cv2.multiply(peak, fraction)))


def components(mask: Array, weight: Array) -> Components:
    """Connected components (8 neighbours) with centroids weighted by `weight`.

    mask: (N, h, w) bool, last row of each tile empty; weight: (N, h, w), positive inside the mask.
    """
    tiles, height, width = mask.shape
    tall = mask.reshape(tiles * height, width).view(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(tall, connectivity=8, ltype=cv2.CV_32S)
    index = np.flatnonzero(tall)
    label = labels.ravel()[index] - 1
    w = weight.ravel()[index].astype(float)
    y, x = np.divmod(index, width)
    total = np.bincount(label, w, count - 1)
    left, top, across, down, area = stats[1:].T
    tile, top = np.divmod(top, height)
    center = np.column_stack(
        [
            np.bincount(label, w * x, count - 1) / total,
            np.bincount(label, w * y, count - 1) / total - tile * height,
        ]
    )
    clipped = np.column_stack([left == 0, top == 0, left + across == width, top + down == height - 1])
    return Components(tile, center, area, clipped, label, index)
