"""Balls that touch in a picture: a component that shows several of them is divided among their forecasts.

As one blob it would have the place of one ball, or a place between them, and the others none. Each pixel goes
to the ball whose centre is forecast nearest to it, in radii of that ball. The seam is no edge in the picture,
so it has no vote for a centre.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot_balls.detection.components import Components, described
from followspot_balls.detection.hough import MERGED
from followspot_balls.detection.search_circles import Circles
from followspot_balls.detection.strip import Strip

SHOWN = 0.35
"""Smallest share of its disc that a component must cover for a ball to be in it."""


def touching(area: Array, view: Array, ball: Array) -> Array:
    """Numbers of the components that are larger than the smallest ball of their view.

    area: (N,) px; view: (N,) of each; ball: (V, T) px, radii of all targets in each view.
    """
    smallest = np.fmin.reduce(ball, axis=1, initial=np.inf)
    return np.asarray((MERGED * np.pi * np.square(smallest.take(view)) < area).nonzero()[0])


def divided(blobs: Components, large: Array, level: Array, strip: Strip, circles: Circles) -> Components:
    """The components, of which those that show several balls are divided among these.

    large: (L,) numbers of those that may; level: (H, W) u8 brightness that they were cut from, in a strip;
    circles: (L, T) of each one's view.
    """
    near = within_reach(blobs.center.take(large, axis=0), blobs.area.take(large), circles)
    several = near.sum(axis=1) > 1
    if not np.count_nonzero(several):
        return blobs
    large, circles = large[several], Circles(*(column[several] for column in circles))
    row, pixel, x, y = placed(blobs, large, strip)
    center, radius2 = circles.center.take(row, axis=0), np.square(circles.ball)
    away = np.square(x[:, None] - center[..., 0])
    away += np.square(y[:, None] - center[..., 1])
    away /= radius2.take(row, axis=0)
    covered = (row == np.arange(len(large))[:, None]).astype(float) @ (away <= 1.0)
    shown = covered >= SHOWN * np.pi * radius2
    several = shown.sum(axis=1) > 1
    if not several.any():
        return blobs
    ball = np.where(shown.take(row, axis=0), away, np.inf).argmin(axis=1)
    part, count = np.zeros(len(blobs.pixels), int), circles.ball.shape[1]
    part[pixel] = np.where(several.take(row), ball, 0)
    used, label = np.unique(blobs.label * count + part, return_inverse=True)
    return described(blobs.pixels, label, len(used), level, strip)


def placed(blobs: Components, chosen: Array, strip: Strip) -> tuple[Array, Array, Array, Array]:
    """The pixels of C chosen components: row of each among the chosen, its number in the strip's pixels, and
    x and y in the picture, px, (Q,) each. chosen: (C,) numbers of components.
    """
    rank = np.full(len(blobs.area), -1)
    rank[chosen] = np.arange(len(chosen))
    row = rank.take(blobs.label)
    pixel = (row >= 0).nonzero()[0]
    row = row.take(pixel)
    shift = strip.shift.take(blobs.part.take(chosen.take(row)), axis=0)
    return row, pixel, blobs.column.take(pixel) + shift[:, 0], blobs.row.take(pixel) + shift[:, 1]


def within_reach(center: Array, area: Array, circles: Circles) -> Array:
    """Which balls components may show, by their area: (L, T) bool.

    The farthest centre of up to six discs in a row, or of two crescents, lies within the root of their area
    and a radius of the centroid.
    center: (L, 2) px, of the components; area: (L,) px; circles: (L, T) of each one's view.
    """
    apart = circles.center - center[:, None]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    return np.asarray(distance <= np.sqrt(area)[:, None] + circles.ball)
