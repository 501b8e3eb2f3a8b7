"""Connected bright components of a strip of small pictures, with sub-pixel centroids."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.strip import REACH, Strip

MOST = 256
"""Components kept, the largest first: more of them are noise, and pairs grow with the square."""
NEIGHBOURHOOD = np.ones((REACH, REACH), np.uint8)


@dataclass(frozen=True, eq=False)
class Components:
    """One row for each of N components; P pixels in them."""

    part: Array
    """(N,) part of the strip that it lies in."""
    center: Array
    """(N, 2) px, x and y of the weighted centroid in the strip."""
    area: Array
    """(N,) px."""
    peak: Array
    """(N,) largest weight in it."""
    pixels: Array
    """(P,) flat index of the pixels in the strip."""
    label: Array
    """(P,) number of the component of each."""


NOTHING = Components(*np.empty((6, 0), int))
NOTHING = replace(NOTHING, center=np.empty((0, 2)), area=np.empty(0), peak=np.empty(0))


def above_local_peak(level: Array, fraction: float) -> Array:
    """Pixels above a fraction of the brightest one near them.

    A ball is cut from a dimmer projection or halo that it touches, whatever the exposure.
    level: (H, W) u8, 0 where nothing is sought. Returns bool, same shape.
    """
    if not level.size:
        return np.zeros(level.shape, bool)
    floor = np.asarray(cv2.convertScaleAbs(cv2.dilate(level, NEIGHBOURHOOD), alpha=fraction))
    return np.asarray(level >= np.maximum(floor, 1, out=floor))


def components(mask: Array, level: Array, strip: Strip) -> Components:
    """Connected components (8 neighbours), with centroids weighted by `level`.

    mask: (H, W) bool, empty between the parts; level: (H, W), positive inside the mask.
    """
    pixels = mask.reshape(-1).nonzero()[0]
    if not len(pixels):
        return NOTHING
    count, labels = cv2.connectedComponents(mask.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    count -= 1  # the background
    label = np.subtract(np.asarray(labels).take(pixels), 1, dtype=np.intp)
    y, x = np.divmod(pixels, mask.shape[1])
    weight = level.take(pixels).astype(float)
    total = np.bincount(label, weight, count)
    center = np.empty((count, 2))
    center[:, 0] = np.bincount(label, weight * x, count)
    center[:, 1] = np.bincount(label, weight * y, count)
    center /= total[:, None]
    peak = np.zeros(count)
    np.maximum.at(peak, label, weight)
    area = np.bincount(label, minlength=count).astype(float)
    part = strip.part.take(center[:, 0].astype(np.intp))
    return Components(part, center, area, peak, pixels, label)


def of_size(area: Array, smallest: Array, largest: Array) -> Array:
    """Which components have an allowed size, at most MOST: (N,) bool.

    area: (N,) px; smallest, largest: (N,) or one for all, px.
    """
    fits = (area >= smallest) & (area <= largest)
    if np.count_nonzero(fits) > MOST:
        size = np.where(fits, area, 0)
        fits[np.argsort(-size, kind="stable")[MOST:]] = False
    return np.asarray(fits)


def clipped(blobs: Components, border: Array) -> Array:
    """Which components touch the border of their window, (N,) bool; border: (H * W,) bool, of all windows."""
    return np.asarray(np.bincount(blobs.label, border.take(blobs.pixels), len(blobs.area)) > 0)
