"""Centres of discs of known radius, by votes of their edges (Hough transform for circles).

The centroid of a partly hidden ball is off by a pixel or more. Its visible rim is still a part of a
circle whose radius follows from the forecast distance, so each edge pixel votes for the point one
radius inward; the rim's votes agree, those of the edge of whatever hides the ball scatter.
"""

from __future__ import annotations

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.components import Components

BORDER = 2
"""Pixels around a picture that the derivative filter needs."""
NEAR = 1.2
"""Largest distance of a voting pixel from the edge, px: the width of the blurred step."""
FAINTEST = 0.08
"""Least slope of a voting pixel, peaks per px."""
UNHEARD = 1e-9
"""Weight of the centre itself, so that it stays where there is no vote."""
SPREADS = (2.0, 1.4, 1.0, 0.8)
"""Scale of the robust kernel in each iteration, px: wide enough to leave a biased centroid, then exact."""


def _stencil() -> Array:
    """Smoothed level and its x and y slopes as linear filters of a 5 x 5 square: (25, 3)."""
    smooth = np.array([0.0, 0.24, 0.52, 0.24, 0.0])
    mean, slope = np.array([3.0, 10.0, 3.0]) / 16, np.array([-1.0, 0.0, 1.0]) / 2
    wide = np.convolve(smooth[1:4], mean)
    steep = np.convolve(smooth[1:4], slope)
    filters = (np.outer(smooth, smooth), np.outer(wide, steep), np.outer(steep, wide))
    return np.stack([f.ravel() for f in filters], axis=1).astype(np.float32)


STENCIL = _stencil()


def disc_centers(level: Array, blobs: Components, radius: Array, edge: float) -> Array:
    """Centres of the discs that the components are visible parts of.

    level: (N, h, w) u8 brightness that the components were cut from, last row of each tile empty;
    radius: (M,) px of each component's disc, NaN where unknown; edge: of a disc over its peak.
    Returns (M, 2) px within the tile; the centroid where the radius is unknown.
    """
    index, label = rim_band(blobs.labels)
    known = ~np.isnan(radius[label])
    index, label = index[known], label[known]
    width = level.shape[2]
    y, x = np.divmod(index, width)
    peak = np.maximum(blobs.peak[label], 1)
    value, right, down = derivatives(level.reshape(-1, width), x, y)
    slope = np.hypot(right, down)
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = (value - edge * peak) / slope
    voter = (np.abs(inside) < NEAR) & (slope > FAINTEST * peak)
    label, slope, x, y = label[voter], slope[voter], x[voter], y[voter]
    reach = (radius[label] - inside[voter]) / slope
    across = x + reach * right[voter]
    along = y + reach * down[voter] - blobs.tile[label] * level.shape[1]
    return agreement(across, along, slope / peak[voter], label, blobs.center)


def rim_band(labels: Array) -> tuple[Array, Array]:
    """Pixels of components and next to them: flat index and row of the component.

    labels: (H, W) u16, 0 for the background.
    """
    grown = cv2.dilate(labels, np.ones((3, 3), np.uint8)).ravel()
    index = np.flatnonzero(grown > 0)
    return index, grown[index].astype(np.intp) - 1


def derivatives(level: Array, x: Array, y: Array) -> Array:
    """Smoothed level and its slopes per px to the right and down at some pixels: (3, P)."""
    padded = np.asarray(cv2.copyMakeBorder(level, BORDER, BORDER, BORDER, BORDER, cv2.BORDER_CONSTANT))
    size = 2 * BORDER + 1
    offsets = (np.arange(size)[:, None] * padded.shape[1] + np.arange(size)).ravel()
    squares = padded.ravel()[(y * padded.shape[1] + x)[:, None] + offsets]
    return np.asarray((squares.astype(np.float32) @ STENCIL).T)


def agreement(x: Array, y: Array, weight: Array, label: Array, start: Array) -> Array:
    """Where most votes of each component agree: a weighted mean, iterated with a narrowing kernel.

    x, y: (P,) px, votes; weight, label: (P,); start: (M, 2) px, kept without votes. Returns (M, 2) px.
    """
    u, v = start.T
    count = len(start)
    for spread in SPREADS:
        distance2 = np.square(x - u[label]) + np.square(y - v[label])
        w = weight / np.square(1 + distance2 / spread**2)
        total = np.bincount(label, w, count) + UNHEARD
        u = (np.bincount(label, w * x, count) + UNHEARD * u) / total
        v = (np.bincount(label, w * y, count) + UNHEARD * v) / total
    return np.column_stack([u, v])
