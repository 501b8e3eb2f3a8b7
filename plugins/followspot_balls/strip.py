"""Many small parts of a picture side by side in one strip, so that one call treats them all.

The parts are search windows of one size, or the clusters in which sought pixels of a whole picture lie.
Empty columns between them are so wide that no part bears upon its neighbour.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array

REACH = 9
"""Side of the square in which the local peak is sought, px: a ball is 5 to 9 px wide."""
GAP = REACH // 2
"""Empty columns after each part, px."""
BLOCK = 4
"""Side of the blocks that clusters consist of, px. Clusters are a whole block or more apart, which is out of
each other's reach."""


class Strip(NamedTuple):
    """Where the N parts lie: W columns."""

    part: Array
    """(W,) part that each column belongs to."""
    shift: Array
    """(N, 2) px, from a place in the strip to that in the picture."""


class Clusters(NamedTuple):
    """E sought pixels in a strip."""

    strip: Strip
    shape: tuple[int, int]
    """Height and width of the strip, px."""
    layer: Array
    """(N,) layer that each part shows."""
    entry: Array
    """(E,) rows of the sought pixels that are in the strip; others lie in clusters that are too small."""
    place: Array
    """(E,) flat index in the strip of each of these."""


def window_strip(corners: Array, side: int) -> Strip:
    """Of square windows. corners: (N, 2) int, x and y of the upper left pixels; side: px."""
    count, wide = len(corners), side + GAP
    shift = corners.copy()
    shift[:, 0] -= np.arange(0, count * wide, wide)
    return Strip(window_columns(count, wide), shift)


@lru_cache(maxsize=64)
def window_columns(count: int, wide: int) -> Array:
    """Number of the window that each column of a strip belongs to: (count * wide,)."""
    return read_only(np.repeat(np.arange(count), wide))


@lru_cache(maxsize=64)
def window_border(count: int, side: int) -> Array:
    """Which pixels of a strip are the outermost of their windows: (side * count * (side + GAP),) bool."""
    border = np.ones((side, count, side + GAP), bool)
    border[1:-1, :, 1 : side - 1] = False
    return read_only(border.reshape(-1))


def read_only(array: Array) -> Array:
    """The array, which nobody may change: others use it too."""
    array.flags.writeable = False
    return array


def whole_strip(width: int) -> Strip:
    """Of the whole picture as the only part."""
    return Strip(np.zeros(width, int), np.zeros((1, 2), int))


def cut(pixels: Array, corners: Array, side: int) -> Array:
    """Copy windows of a picture into a strip; black where they reach beyond it.

    pixels: (H, W, C); corners, side: as above. Returns (side, N * (side + GAP), C).
    """
    strip = np.zeros((side, len(corners) * (side + GAP), pixels.shape[2]), pixels.dtype)
    bottom, right = pixels.shape[:2]
    for number, (x, y) in enumerate(corners.tolist()):
        left, top = max(x, 0), max(y, 0)
        part = pixels[top : max(y + side, 0), left : max(x + side, 0)]
        if left < right and top < bottom and part.size:
            start = number * (side + GAP) + left - x
            strip[top - y : top - y + part.shape[0], start : start + part.shape[1]] = part
    return strip


def clusters(layer: Array, y: Array, x: Array, size: tuple[int, int, int], smallest: Array) -> Clusters:
    """Sought pixels of whole pictures, gathered into a strip that is much smaller than these.

    layer, y, x: (E,) of the sought pixels; size: number of layers, height and width of the pictures, px;
    smallest: (layers,) number of pixels that a cluster must have.
    """
    layers, height, width = size
    rows, columns = height // BLOCK + 2, width // BLOCK + 1  # an empty row parts the layers
    block = (layer * rows + y // BLOCK) * columns + x // BLOCK
    taken = np.zeros((layers * rows, columns), np.uint8)
    taken.reshape(-1)[block] = 1
    count, labels = cv2.connectedComponents(taken, connectivity=8, ltype=cv2.CV_32S)
    cluster = labels.reshape(-1).take(block)
    of_layer = np.zeros(count, int)
    of_layer[cluster] = layer
    keep = np.flatnonzero(np.bincount(cluster, minlength=count) >= smallest.take(of_layer))
    keep = keep[keep > 0]
    part = np.full(count, -1)
    part[keep] = np.arange(len(keep))
    part = part.take(cluster)
    entry = np.flatnonzero(part >= 0)
    part, y, x = part.take(entry), y.take(entry), x.take(entry)
    top, left, bottom, right = extents(part, y, x, len(keep))
    top, left, bottom = top - 1, left - 1, bottom + 1  # an empty rim, for the edges of what touches it
    wide = right - left + 1 + GAP
    start = np.cumsum(wide) - wide
    shape = (int((bottom - top).max(initial=0)) + 1, int(wide.sum()))
    shift = np.column_stack([left - start, top])
    place = (y - top.take(part)) * shape[1] + x - shift[:, 0].take(part)
    return Clusters(Strip(np.repeat(np.arange(len(keep)), wide), shift), shape, of_layer[keep], entry, place)


def scattered(found: Clusters, values: Array) -> Array:
    """The strip with these values at the sought pixels, (E,), and 0 elsewhere."""
    plane = np.zeros(found.shape, values.dtype)
    plane.reshape(-1)[found.place] = values
    return plane


def extents(part: Array, y: Array, x: Array, count: int) -> tuple[Array, Array, Array, Array]:
    """Top, left, bottom and right of each of `count` groups of pixels: (count,) each."""
    low, high = np.full((2, count), np.iinfo(int).max), np.zeros((2, count), int)
    for row, value in enumerate((y, x)):
        np.minimum.at(low[row], part, value)
        np.maximum.at(high[row], part, value)
    return low[0], low[1], high[0], high[1]
