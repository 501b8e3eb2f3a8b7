"""Centres of discs of known radius, by votes of their edges (Hough transform for circles).

The centroid of a partly hidden ball is off by a pixel or more. Its visible rim is still a part of a
circle whose radius follows from the forecast distance, so each edge pixel votes for the point one
radius inward; the rim's votes agree, those of the edge of whatever hides the ball scatter.
"""

from __future__ import annotations

from functools import lru_cache

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
TOUCHING = np.ones((3, 3), np.uint8)


def _stencil() -> Array:
    """Smoothed level and its x and y slopes as linear filters of a 5 x 5 square: (3, 25)."""
    smooth = np.array([0.0, 0.24, 0.52, 0.24, 0.0])
    mean, slope = np.array([3.0, 10.0, 3.0]) / 16, np.array([-1.0, 0.0, 1.0]) / 2
    wide = np.convolve(smooth[1:4], mean)
    steep = np.convolve(smooth[1:4], slope)
    filters = (np.outer(smooth, smooth), np.outer(wide, steep), np.outer(steep, wide))
    return np.stack([f.ravel() for f in filters]).astype(np.float32)


STENCIL = _stencil()


def disc_centers(level: Array, blobs: Components, radius: Array, edge: float) -> Array:
    """Centres of the discs that the components are visible parts of.

    level: (H, W) u8 brightness that the components were cut from;
    radius: (N,) px of each component's disc, NaN where unknown; edge: of a disc over its peak.
    Returns (N, 2) px in the strip; the centroid where the radius is unknown.
    """
    known = ~np.isnan(radius)
    if not known.any():
        return blobs.center
    index, label = rim_band(blobs, known, level.shape)
    y, x = np.divmod(index, level.shape[1])
    slopes = derivatives(level, x, y)
    value, slopes = slopes[0], slopes[1:]
    peak = blobs.peak.take(label)
    slope, height = np.hypot(*slopes), value - edge * peak
    voter = np.abs(height) < NEAR * slope
    voter &= slope > FAINTEST * peak
    chosen = np.flatnonzero(voter)
    label, x, y, slope = label.take(chosen), x.take(chosen), y.take(chosen), slope.take(chosen)
    reach = (radius.take(label) - height.take(chosen) / slope) / slope
    votes = np.array([x, y]) + reach * slopes.take(chosen, axis=1)
    return agreement(votes, slope / peak.take(chosen), label, blobs.center)


def rim_band(blobs: Components, known: Array, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Pixels of some components and next to them: flat index and number of the component.

    known: (N,) bool, which; shape: of the strip.
    """
    labels = np.zeros(shape, np.uint16)
    code = (np.arange(1, len(known) + 1) * known).astype(np.uint16)
    labels.reshape(-1)[blobs.pixels] = code.take(blobs.label)
    grown = np.asarray(cv2.dilate(labels, TOUCHING)).reshape(-1)
    index = np.flatnonzero(grown > 0)
    return index, grown.take(index).astype(np.intp) - 1


def derivatives(level: Array, x: Array, y: Array) -> Array:
    """Smoothed level and its slopes per px to the right and down at some pixels: (3, P)."""
    padded = np.asarray(cv2.copyMakeBorder(level, BORDER, BORDER, BORDER, BORDER, cv2.BORDER_CONSTANT))
    squares = padded.reshape(-1).take(y * padded.shape[1] + x + square_offsets(padded.shape[1]))
    return np.asarray(STENCIL @ squares.astype(np.float32))


@lru_cache(maxsize=64)
def square_offsets(width: int) -> Array:
    """From the first pixel of a 5 x 5 square to all of it, as flat indices in a picture: (25, 1)."""
    side = np.arange(2 * BORDER + 1)
    return (side[:, None] * width + side).reshape(-1, 1)


def agreement(votes: Array, weight: Array, label: Array, start: Array) -> Array:
    """Where most votes of each component agree: a weighted mean, iterated with a narrowing kernel.

    votes: (2, P) px, x and y; weight, label: (P,); start: (M, 2) px, kept without votes. Returns (M, 2) px.
    """
    center, count = start.T, len(start)
    for spread in SPREADS:
        offset = votes - center.take(label, axis=1)
        offset *= offset
        kernel = offset[0] + offset[1]
        kernel += spread**2
        heard = weight / (kernel * kernel)
        x, y = heard * votes
        sums = np.array([np.bincount(label, values, count) for values in (x, y, heard)])
        center = (sums[:2] + UNHEARD * center) / (sums[2] + UNHEARD)
    return center.T
