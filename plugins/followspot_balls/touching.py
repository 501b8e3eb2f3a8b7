"""Balls that touch in a picture: a component that shows several of them is divided among their forecasts.

As one blob it would have the place of one ball, or a place between them, and the others none. Each pixel goes
to the ball whose centre is forecast nearest to it, in radii of that ball. The seam is no edge in the picture,
so it has no vote for a centre.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot_balls.components import Components, described
from followspot_balls.search import Circles
from followspot_balls.strip import Strip
from followspot_balls.votes import MERGED

SHOWN = 0.35
"""Smallest share of its disc that a component must cover for a ball to be in it."""


def divided(blobs: Components, level: Array, strip: Strip, circles: Circles) -> Components:
    """The components, of which those that show several balls are divided among these.

    level: (H, W) u8 brightness that they were cut from, in a strip; circles: (N, T) of each component's view.
    """
    disc = np.pi * np.square(circles.ball)
    large = np.fmin.reduce(disc, axis=1, initial=np.inf) * MERGED < blobs.area
    if not large.any():
        return blobs
    part, count = np.zeros(len(blobs.pixels), int), circles.ball.shape[1]
    for number in large.nonzero()[0]:
        mine = (blobs.label == number).nonzero()[0]
        xy = np.column_stack([blobs.column[mine], blobs.row[mine]]) + strip.shift[blobs.part[number]]
        off = xy[:, None] - circles.center[number]
        away = np.hypot(off[..., 0], off[..., 1]) / circles.ball[number]
        shown = (away <= 1.0).sum(axis=0) >= SHOWN * disc[number]
        if np.count_nonzero(shown) > 1:
            part[mine] = np.where(shown, away, np.inf).argmin(axis=1)
    if not part.any():
        return blobs
    used, label = np.unique(blobs.label * count + part, return_inverse=True)
    return described(blobs.pixels, label, len(used), level, strip)
