"""Connected bright components of several small pictures at once, with sub-pixel centroids."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from followspot.messages import Array

REACH = 9
"""Side of the square in which the local peak is sought, px: a ball is 5 to 9 px wide."""
MOST = 256
"""Components kept, the largest first: more of them are noise, and pairs grow with the square."""


@dataclass(frozen=True, eq=False)
class Components:
    """One row for each of N components; the tiles stand on top of each other, h rows each."""

    tile: Array
    """(N,) tile that it lies in."""
    center: Array
    """(N, 2) px, x and y of the weighted centroid within the tile."""
    area: Array
    """(N,) px."""
    peak: Array
    """(N,) largest weight in it."""
    clipped: Array
    """(N,) bool: touches the border of its tile."""
    pixels: Array
    """(P,) flat index of the pixels of all components in the tiles."""
    label: Array
    """(P,) row of the component of each of these pixels."""
    labels: Array
    """(tiles * h, w) u16: 1 + row of the component at each pixel, 0 outside."""


def cut(pixels: Array, corners: Array, height: int, width: int) -> Array:
    """Copy windows of a picture into a stack; black where they reach beyond it.

    pixels: (H, W, C); corners: (N, 2) int, x and y of the upper left pixel. Returns (N, height + 1,
    width, C), with an empty last row, so that the stack may be treated as one tall picture.
    """
    tiles = np.zeros((len(corners), height + 1, width, pixels.shape[2]), pixels.dtype)
    bottom, right = pixels.shape[:2]
    for tile, (x, y) in zip(tiles, corners.tolist(), strict=True):
        left, top = max(x, 0), max(y, 0)
        part = pixels[top : max(y + height, 0), left : max(x + width, 0)]
        if part.size and left < right and top < bottom:
            tile[top - y : top - y + part.shape[0], left - x : left - x + part.shape[1]] = part
    return tiles


def above_local_peak(level: Array, fraction: float) -> Array:
    """Pixels above a fraction of the brightest one near them.

    A ball is cut from a dimmer projection or halo that it touches, whatever the exposure.
    level: (N, h, w) u8, 0 where nothing is sought, last row of each tile empty. Returns bool, same shape.
    """
    tall = level.reshape(-1, level.shape[2])
    floor = cv2.convertScaleAbs(cv2.dilate(tall, np.ones((REACH, REACH), np.uint8)), alpha=fraction)
    return np.asarray(((tall > 0) & (tall >= floor)).reshape(level.shape))


def components(mask: Array, level: Array, area: Array) -> Components:
    """Connected components (8 neighbours) of allowed size, with centroids weighted by `level`.

    mask: (N, h, w) bool, last row of each tile empty; level: (N, h, w), positive inside the mask;
    area: (N, 2) smallest and largest for each tile, px.
    """
    tiles, height, width = mask.shape
    tall = mask.reshape(tiles * height, width).view(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(tall, connectivity=8, ltype=cv2.CV_32S)
    tile, top = np.divmod(stats[:, cv2.CC_STAT_TOP], height)
    keep = allowed(stats[:, cv2.CC_STAT_AREA], area[np.minimum(tile, tiles - 1)])
    row = np.full(len(stats), -1)
    row[keep] = np.arange(len(keep))
    pixels = np.flatnonzero(mask)
    label = row[labels.ravel()[pixels]]
    pixels, label = pixels[label >= 0], label[label >= 0]
    kept = np.zeros(tall.shape, np.uint16)
    kept.ravel()[pixels] = label + 1
    left, _, across, down, size = stats[keep].T
    tile, top = tile[keep], top[keep]
    center, peak = centroids(pixels, label, level.ravel()[pixels], len(keep), width)
    center[:, 1] -= tile * height
    edge = (left == 0) | (top == 0) | (left + across == width) | (top + down == height - 1)
    return Components(tile, center, size.astype(float), peak, edge, pixels, label, kept)


def allowed(size: Array, area: Array) -> Array:
    """Rows of the components of allowed size, at most MOST; row 0 is the background."""
    fits = (size >= area[:, 0]) & (size <= area[:, 1])
    fits[0] = False
    keep = np.flatnonzero(fits)
    return keep if len(keep) <= MOST else np.sort(keep[np.argsort(-size[keep], kind="stable")[:MOST]])


def centroids(pixels: Array, label: Array, level: Array, count: int, width: int) -> tuple[Array, Array]:
    """Weighted centroid (count, 2) and largest weight (count,) of labelled pixels of a picture."""
    weight = level.astype(float)
    y, x = np.divmod(pixels, width)
    total = np.bincount(label, weight, count)
    moments = [np.bincount(label, weight * axis, count) / total for axis in (x, y)]
    peak = np.zeros(count)
    np.maximum.at(peak, label, weight)
    return np.column_stack(moments), peak
