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
    count, labels = cv2.connectedComponents(tall, connectivity=8, ltype=cv2.CV_32S)
    pixels = np.flatnonzero(mask)
    label = labels.reshape(-1)[pixels]
    tile = np.zeros(count, int)
    tile[label] = pixels // (height * width)
    keep = allowed(np.bincount(label, minlength=count), area[np.minimum(tile, len(area) - 1)])
    row = np.full(count, -1)
    row[keep] = np.arange(len(keep))
    pixels, label = pixels[row[label] >= 0], row[label][row[label] >= 0]
    kept = np.zeros(tall.shape, np.uint16)
    kept.reshape(-1)[pixels] = label + 1
    return measured(pixels, label, level, tile[keep], kept)


def allowed(size: Array, area: Array) -> Array:
    """Rows of the components of allowed size, at most MOST; row 0 is the background."""
    fits = (size >= area[:, 0]) & (size <= area[:, 1])
    fits[0] = False
    keep = np.flatnonzero(fits)
    return keep if len(keep) <= MOST else np.sort(keep[np.argsort(-size[keep], kind="stable")[:MOST]])


def measured(pixels: Array, label: Array, level: Array, tile: Array, labels: Array) -> Components:
    """Area, weighted centroid, peak and contact with the tile's border of labelled pixels."""
    _, height, width = level.shape
    count = len(tile)
    weight = level.reshape(-1)[pixels].astype(float)
    y, x = np.divmod(pixels, width)
    y -= tile[label] * height
    total = np.bincount(label, weight, count)
    center = [np.bincount(label, weight * axis, count) / total for axis in (x, y)]
    border = (x == 0) | (y == 0) | (x == width - 1) | (y == height - 2)
    peak = np.zeros(count)
    np.maximum.at(peak, label, weight)
    return Components(
        tile=tile,
        center=np.column_stack(center),
        area=np.bincount(label, minlength=count).astype(float),
        peak=peak,
        clipped=np.bincount(label, border, count) > 0,
        pixels=pixels,
        label=label,
        labels=labels,
    )
