"""Centres of discs of known radius, by votes of their edges (Hough transform for circles).

The centroid of a partly hidden ball is off by a pixel or more. Its visible rim is still a part of a
circle whose radius follows from the forecast distance, so each edge pixel votes for the point one
radius inward; the rim's votes agree, those of the edge of an occluder scatter. A blob that is larger than
the ball shows it beside other light, and its centroid lies between them: then the votes around the
forecast count as well, and if most of a rim agrees there is a ball, however large the blob.

Balls side by side are often covered on two sides, by each other and by the hands that pass them. The votes of
both edges then lie nearer to the centroid of what is left than those of the rim do, so there the votes around
the forecast count as well. No other fragment asks the forecast, which few votes would always confirm.
"""

from __future__ import annotations

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.detection.components import Components
from followspot_balls.detection.strip import Strip, row_and_column

SMOOTH = np.array([6.0, 13.0, 6.0], np.float32)
"""Filter along rows and columns before the slopes are taken."""
SCHARR = 32.0
"""Gain of Scharr's filters, which take the slopes."""
GAIN = SMOOTH.sum() ** 2 * SCHARR
"""Gain of both filters together. They are integers, so that sums are exact in any order."""
NEAR = 1.2
"""Largest distance of a voting pixel from the edge, px: the width of the blurred step."""
FAINTEST = 0.08
"""Smallest slope of a voting pixel, peaks per px."""
UNHEARD = 1e-9
"""Weight of the centroid itself, so that it stays if there is no vote."""
SPREADS = (2.0, 1.4, 1.0, 0.8)
"""Scale of the robust kernel in each iteration, px: wide enough to leave a biased centroid, then exact."""
WHOLE_RIM = 4.3
"""Votes of the rim of a ball in clear view that agree on its centre, over its radius in px."""
SEPARATE = 0.7
"""Share of these votes from which a ball is told from the light that it is merged with."""
MERGED = 1.2
"""Area over the disc's above which a component is merged with other light."""
TOUCHING = np.ones((3, 3), np.uint8)


def disc_centers(
    level: Array,
    strip: Strip,
    blobs: Components,
    radius: Array,
    edge: float,
    expected: Array | None = None,
    beside: Array | None = None,
) -> tuple[Array, Array]:
    """Centres of the discs whose visible parts are the components.

    level: (H, W) u8 brightness that the components were cut from, in a strip;
    radius: (N,) px of each component's disc, NaN if unknown; edge: of a disc over its peak; expected:
    (N, 2) px, where the discs of known radius are forecast; beside: (N,) bool, those that another may cover.
    Returns (N, 2) px in the picture, the centroid if the radius is unknown, and the share of a whole rim that
    votes for it, (N,), 0 if the radius is unknown.
    """
    known = np.equal(radius, radius).nonzero()[0]
    rim = np.zeros(len(radius))
    if not len(known):
        return blobs.center, rim
    radius = radius.take(known)
    votes, slope, label = rim_votes(level, strip, blobs, known, radius, edge)
    start, area = blobs.center.take(known, axis=0), blobs.area.take(known)
    doubtful = area > MERGED * np.pi * (radius * radius)
    if beside is not None:
        doubtful |= beside.take(known)
    asking = doubtful.nonzero()[0]
    if expected is None or not len(asking):
        point, heard = agreement(votes, slope, label, start)
    else:
        forecast = expected.take(known.take(asking), axis=0)
        point, heard = better_agreement(votes, slope, label, start, asking, forecast)
    center = blobs.center.copy()
    center[known] = point
    rim[known] = heard / (WHOLE_RIM * radius)
    return center, rim


def own_area(area: Array, largest: Array, radius: Array, rim: Array) -> Array:
    """Areas of the balls in components, px: that of its disc if a larger one has a rim that tells it.

    area: (N,) px, of the components; largest: (N,) px, that balls have; radius: (N,) px, of the discs; rim:
    (N,) of :func:`disc_centers`.
    """
    merged = (area > largest) & (rim >= SEPARATE)
    return np.where(merged, np.pi * np.square(radius), area) if np.count_nonzero(merged) else area


def rim_votes(
    level: Array, strip: Strip, blobs: Components, known: Array, radius: Array, edge: float
) -> tuple[Array, Array, Array]:
    """For each pixel near an edge of a component the point one radius inward.

    known: (K,) numbers of the components; radius: (K,) px; the others as of :func:`disc_centers`.
    Returns (2, P) px in the picture, x and y; (P,) slope at the pixel, peaks per px; (P,) rows of `known`.
    """
    index, label = rim_band(blobs, known, level.shape)
    planes = derivatives(level, index) / (GAIN * blobs.peak.take(known)).take(label)
    right, down, value = planes
    slope = np.sqrt(right * right + down * down)
    height = value - edge
    voter = np.abs(height) < NEAR * slope
    voter &= slope > FAINTEST
    chosen = voter.nonzero()[0]
    label, slope, height = label.take(chosen), slope.take(chosen), height.take(chosen)
    reach = (radius.take(label) - height / slope) / slope
    votes = planes[:2].take(chosen, axis=1) * reach
    y, x = row_and_column(index.take(chosen), level.shape[1])
    shift = strip.shift.take(blobs.part.take(known), axis=0)
    votes[0] += x + shift[:, 0].take(label)
    votes[1] += y + shift[:, 1].take(label)
    return votes, slope, label


def rim_band(blobs: Components, known: Array, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Pixels of these components and their neighbours: flat index, and number among the components.

    known: (K,) which components; shape: of the strip.
    """
    code = np.zeros(len(blobs.area), np.uint16)
    code[known] = np.arange(1, len(known) + 1)
    labels = np.zeros(shape, np.uint16)
    labels.reshape(-1)[blobs.pixels] = code.take(blobs.label)
    grown = np.asarray(cv2.dilate(labels, TOUCHING)).reshape(-1)
    index = (grown > 0).nonzero()[0]
    return index, grown.take(index).astype(np.intp) - 1


def derivatives(level: Array, index: Array) -> Array:
    """Slopes per px to the right and down, and smoothed level, GAIN times, at some pixels: (3, P) float32.

    level: (H, W) u8; index: (P,) flat.
    """
    planes = np.empty((3, *level.shape), np.float32)
    right, down, smooth = planes
    cv2.sepFilter2D(level, cv2.CV_32F, SMOOTH, SMOOTH, smooth, borderType=cv2.BORDER_CONSTANT)
    cv2.Scharr(smooth, cv2.CV_32F, 1, 0, right, borderType=cv2.BORDER_CONSTANT)
    cv2.Scharr(smooth, cv2.CV_32F, 0, 1, down, borderType=cv2.BORDER_CONSTANT)
    found = planes.reshape(3, -1).take(index, axis=1)
    found[2] *= SCHARR
    return found


def agreement(votes: Array, weight: Array, label: Array, start: Array) -> tuple[Array, Array]:
    """The point where most votes of each component agree: an iterated weighted mean with a narrowing kernel.

    votes: (2, P) px, x and y; weight, label: (P,); start: (K, 2) px, kept without votes.
    Returns (K, 2) px, and the votes that agree on each, (K,).
    """
    count = len(start)
    bins = (label + count * np.arange(3)[:, None]).reshape(-1)
    terms = np.empty((3, len(label)))
    sums = np.ones((3, count))
    sums[:2] = start.T
    faint = UNHEARD * sums
    for spread in SPREADS:
        offset = (sums[:2] / sums[2]).take(label, axis=1)
        offset -= votes
        offset *= offset
        kernel = offset[0]
        kernel += offset[1]
        kernel += spread * spread
        kernel *= kernel
        np.divide(weight, kernel, out=terms[2])
        np.multiply(votes, terms[2], out=terms[:2])
        heard = np.bincount(bins, terms.reshape(-1), 3 * count)
        sums = heard.reshape(3, count) + faint
    return np.asarray(sums[:2] / sums[2]).T, sums[2]


def better_agreement(
    votes: Array, weight: Array, label: Array, start: Array, asking: Array, other: Array
) -> tuple[Array, Array]:
    """As :func:`agreement`, where some components also begin at another point: the one with more votes holds.

    asking: (M,) numbers of these components; other: (M, 2) px.
    """
    count = len(start)
    twin = np.full(count, -1)
    twin[asking] = np.arange(count, count + len(asking))
    again = twin.take(label)
    mine = (again >= 0).nonzero()[0]
    point, heard = agreement(
        np.concatenate([votes, votes.take(mine, axis=1)], axis=1),
        np.concatenate([weight, weight.take(mine)]),
        np.concatenate([label, again.take(mine)]),
        np.concatenate([start, other]),
    )
    best, better = np.arange(count), (heard[count:] > heard.take(asking)).nonzero()[0]
    best[asking.take(better)] = better + count
    return point.take(best, axis=0), heard.take(best)
