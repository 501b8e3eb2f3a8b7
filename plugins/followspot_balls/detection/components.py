"""Connected bright components of a strip of small pictures, with sub-pixel centroids."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.detection.strip import REACH, Strip, Windows, at_border, row_and_column

MOST = 256
"""Largest number of components per view, largest first: more are noise, and pairs grow with the square."""
NEIGHBOURHOOD = np.ones((REACH, REACH), np.uint8)


@dataclass(frozen=True, eq=False)
class Components:
    """One row for each of N components; P pixels in them."""

    part: Array
    """(N,) part of the strip that it lies in."""
    center: Array
    """(N, 2) px, x and y of the weighted centroid in the picture."""
    area: Array
    """(N,) px."""
    peak: Array
    """(N,) largest weight in it."""
    pixels: Array
    """(P,) flat index of the pixels in the strip."""
    row: Array
    """(P,) row in the strip."""
    column: Array
    """(P,) column in the strip."""
    label: Array
    """(P,) component of each pixel."""


NOTHING = Components(*np.empty((8, 0), int))
NOTHING = replace(NOTHING, center=np.empty((0, 2)), area=np.empty(0), peak=np.empty(0))


def above_local_peak(level: Array, fraction: float) -> Array:
    """Pixels above a fraction of the brightest one near them.

    A ball is cut from a dimmer projection or halo that it touches, whatever the exposure.
    level: (H, W) u8, 0 if nothing is sought. Returns bool, same shape.
    """
    if not level.size:
        return np.zeros(level.shape, bool)
    mask = level >= np.asarray(cv2.convertScaleAbs(cv2.dilate(level, NEIGHBOURHOOD), alpha=fraction))
    mask &= level > 0
    return np.asarray(mask)


def components(mask: Array, level: Array, strip: Strip) -> Components:
    """Connected components (8 neighbours), with centroids weighted by `level`.

    They are in the order in which pairs of rows first show them, from the left: that of a part does not
    depend on the others.
    mask: (H, W) bool, empty between the parts; level: (H, W), positive inside the mask.
    """
    pixels = mask.reshape(-1).nonzero()[0]
    if not len(pixels):
        return NOTHING
    count, labels = cv2.connectedComponentsWithAlgorithm(mask.view(np.uint8), 8, cv2.CV_32S, cv2.CCL_BBDT)
    count -= 1  # the background
    label = np.subtract(np.asarray(labels).take(pixels), 1, dtype=np.intp)
    return described(pixels, label, count, level, strip)


def described(pixels: Array, label: Array, count: int, level: Array, strip: Strip) -> Components:
    """The components of pixels that have their labels: (P,) flat indices and labels below `count`, each used.

    level: (H, W), positive there.
    """
    row, column = row_and_column(pixels, level.shape[1])
    weight = level.take(pixels).astype(float)
    total = np.bincount(label, weight, count)
    center = np.empty((count, 2))
    center[:, 0] = np.bincount(label, weight * column, count)
    center[:, 1] = np.bincount(label, weight * row, count)
    part = strip.part.take((center[:, 0] / total).astype(np.intp))
    center += total[:, None] * strip.shift.take(part, axis=0)  # sums of whole numbers: exact
    center /= total[:, None]
    peak = np.zeros(count)
    np.maximum.at(peak, label, weight)
    area = np.bincount(label, minlength=count).astype(float)
    return Components(part, center, area, peak, pixels, row, column, label)


def of_size(area: Array, smallest: Array, largest: Array | float, view: Array) -> Array:
    """Which components have an allowed size, at most MOST of each view: (N,) bool.

    area: (N,) px; smallest, largest: (N,) px; view: (N,) number of the picture that each is seen in.
    """
    fits = (area >= smallest) & (area <= largest)
    if np.count_nonzero(fits) > MOST:
        rows = fits.nonzero()[0]
        rows = rows[np.lexsort((-area[rows], view[rows]))]
        first = np.searchsorted(view[rows], view[rows])
        fits[rows[np.arange(len(rows)) - first >= MOST]] = False
    return np.asarray(fits)


def clipped(blobs: Components, strip: Strip, windows: Windows) -> Array:
    """Which components of a strip of windows touch the border of theirs, (N,) bool."""
    touching = np.zeros(len(blobs.area), bool)
    border = at_border(blobs.row, blobs.column, strip.part, windows).nonzero()[0]
    touching[blobs.label.take(border)] = True
    return touching
