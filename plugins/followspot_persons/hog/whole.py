"""Whole bodies: legs below an upper body speak for it, where the picture has them.

A network and boosted trees look at the whole person in windows that are in doubt. They never speak against
anybody, for legs may be hidden.
"""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.hog.search import nesting
from followspot_persons.hog.whole_model import LAYOUT, WholeModel, whole_log_odds
from followspot_persons.hog.window import cut

FEET = 120.0
"""Row of the layout that must be in the picture."""
DOUBT = -3.5
"""Score of an upper body below which the whole one is not looked at."""


def raised(model: WholeModel, share: float, pixels: Array, box: Array, score: Array) -> Array:
    """Scores of upper bodies, raised where the whole body is surer: to the mean of both log-odds.

    share: of the whole body in this mean; pixels: (H, W, 3) u8; box: (N, 4) px; score: (N,). Returns (N,).
    """
    rows, out = np.flatnonzero((score > DOUBT) & within(box, pixels.shape)), score.copy()
    if len(rows):
        said = whole_log_odds(model, windows(pixels, box[rows]))
        out[rows] += share * np.maximum(said - score[rows], 0)
    return out


def within(box: Array, shape: tuple[int, ...]) -> Array:
    """Whether the feet and both sides of the upper bodies (N, 4) px are in a picture of a shape: (N,)."""
    tall, middle = box[:, 3] - box[:, 1], (box[:, 0] + box[:, 2]) / 2
    feet = box[:, 1] + tall * ((FEET - LAYOUT.top) / LAYOUT.tall)
    return np.asarray((feet <= shape[0]) & (middle >= tall / 3) & (middle + tall / 3 <= shape[1]))


def extents(box: Array) -> Array:
    """Where the whole bodies of upper ones may be, boxes (N, 4) px."""
    tall, middle = box[:, 3] - box[:, 1], (box[:, 0] + box[:, 2]) / 2
    aside = tall * (LAYOUT.width / LAYOUT.tall / 2)
    feet = tall * ((LAYOUT.height - LAYOUT.top) / LAYOUT.tall)
    return np.column_stack([middle - aside, box[:, 1], middle + aside, box[:, 1] + feet])


def parts(box: Array, doubtful: Array, most: float, turn: float) -> Array:
    """Which boxes are an arm and a leg of a surer person: doubtful ones inside that person, (N,) bool.

    box: (N, 4) px, the surest first; doubtful: (N,) bool, whether legs alone make the box a person; most:
    share of such a box inside another person from which it is a part; turn: width of a panorama, px, else 0.
    """
    found = np.zeros(len(box), bool)
    whole = extents(box)
    for row in doubtful.nonzero()[0].tolist():
        surer = whole[:row][~found[:row]]
        found[row] = len(surer) > 0 and nesting(box[row], surer, turn).max() > most
    return found


def windows(pixels: Array, box: Array) -> list[Array]:
    """The whole bodies of boxes (N, 4) px, each of the size of the layout."""
    return [cut(pixels, one, layout=LAYOUT) for one in box]
