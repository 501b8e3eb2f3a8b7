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
    x: Array
    """(P,) column of each of these pixels, px."""
    y: Array
    """(P,) row, px."""
    label: Array
    """(P,) number of the component of each."""


NOTHING = Components(*np.empty((8, 0), int))
NOTHING = replace(NOTHING, center=np.empty((0, 2)), area=np.empty(0), peak=np.empty(0))


def above_local_peak(level: Array, fraction: float) -> Array:
    """Pixels above a fraction of the brightest one near them.

    A ball is cut from a dimmer projection or halo that it touches, whatever the exposure.
    level: (H, W) u8, 0 where nothing is sought. Returns bool, same shape.
    """
    if not level.size:
        return np.zeros(level.shape, bool)
    floor = cv2.convertScaleAbs(cv2.dilate(level, NEIGHBOURHOOD), alpha=fraction)
    above = level >= np.asarray(floor)
    above &= level > 0
    return np.asarray(above)


def components(mask: Array, level: Array, strip: Strip, area: Array) -> Components:
    """Connected components (8 neighbours) of allowed size, with centroids weighted by `level`.

    mask: (H, W) bool, empty between the parts; level: (H, W), positive inside the mask;
    area: (parts, 2) smallest and largest, px.
    """
    pixels = np.flatnonzero(mask)
    if not len(pixels):
        return NOTHING
    count, labels = cv2.connectedComponents(mask.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    label: Array = np.asarray(labels).reshape(-1).take(pixels)
    y, x = np.divmod(pixels, mask.shape[1])
    part = np.zeros(count, int)
    part[label] = strip.part.take(x)
    keep = allowed(np.bincount(label, minlength=count), area.take(part, axis=0))
    if len(keep) < count - 1:
        row = np.full(count, -1)
        row[keep] = np.arange(len(keep))
        label = row.take(label)
        chosen = np.flatnonzero(label >= 0)
        label, pixels, y, x = (values.take(chosen) for values in (label, pixels, y, x))
    else:
        label = label.astype(np.intp) - 1
    return measured(part.take(keep), pixels, x, y, label, level)


def allowed(size: Array, area: Array) -> Array:
    """Rows of the components of allowed size, at most MOST; row 0 is the background."""
    fits = (size >= area[:, 0]) & (size <= area[:, 1])
    fits[0] = False
    keep = np.flatnonzero(fits)
    return keep if len(keep) <= MOST else np.sort(keep[np.argsort(-size[keep], kind="stable")[:MOST]])


def measured(part: Array, pixels: Array, x: Array, y: Array, label: Array, level: Array) -> Components:
    """Area, weighted centroid and peak of labelled pixels."""
    count = len(part)
    weight = level.reshape(-1).take(pixels).astype(float)
    center = np.empty((count, 2))
    total = np.bincount(label, weight, count)
    np.divide(np.bincount(label, weight * x, count), total, out=center[:, 0])
    np.divide(np.bincount(label, weight * y, count), total, out=center[:, 1])
    peak = np.zeros(count)
    np.maximum.at(peak, label, weight)
    area = np.bincount(label, minlength=count).astype(float)
    return Components(part, center, area, peak, pixels, x, y, label)


def clipped(blobs: Components, side: int, pitch: int) -> Array:
    """Which components touch the border of their window, (N,) bool.

    side: of the windows, px; pitch: from one to the next, px.
    """
    x, last = blobs.x % pitch, side - 1
    border = (x == 0) | (x == last) | (blobs.y == 0) | (blobs.y == last)
    return np.asarray(np.bincount(blobs.label, border, len(blobs.area)) > 0)
