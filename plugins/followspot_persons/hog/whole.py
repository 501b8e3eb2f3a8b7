"""Whole bodies: legs below an upper body speak for it, where the picture has them.

Boosted trees over the channels of the whole person look at windows that are in doubt. They never speak
against anybody, for legs may be hidden.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.array_files import read_arrays
from followspot.errors import InputError, Mistake
from followspot_persons.hog.channels import CELL, MAPS, channels
from followspot_persons.hog.search import nesting
from followspot_persons.hog.trees import Trees, check, log_odds
from followspot_persons.hog.window import Layout, cut

SHIPPED_WHOLE = Path(__file__).with_name("hog_weights_whole.npz")
LAYOUT = Layout(64, 128, 14.0, 44.0)
"""Window of a whole person, standing upright."""
FEET = 120.0
"""Row of it that must be in the picture."""
INPUTS = MAPS * (LAYOUT.width // CELL) * (LAYOUT.height // CELL)
"""Number of features of a window."""
DOUBT = -2.5
"""Score of an upper body below which the whole one is not looked at."""


def raised(trees: Trees, share: float, pixels: Array, box: Array, score: Array) -> Array:
    """Scores of upper bodies, raised where the whole body is surer: to the mean of both log-odds.

    share: of the whole body in this mean; pixels: (H, W, 3) u8; box: (N, 4) px; score: (N,). Returns (N,).
    """
    rows = np.flatnonzero((score > DOUBT) & within(box, pixels.shape))
    said = log_odds(trees, channels(windows(pixels, box[rows])))
    out = score.copy()
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


@cache
def load(path: Path = SHIPPED_WHOLE) -> Trees:
    """Read a file of trees. Raises InputError if it is invalid."""
    try:
        stored = read_arrays(path)
        feature = stored["tree_feature"].astype(np.intp)
        bounds, leaves = (stored[name].astype(np.float32) for name in ("tree_threshold", "tree_leaf"))
        trees = Trees(feature, bounds, leaves)
        check(trees, INPUTS)
    except (OSError, ValueError, KeyError) as error:
        remedy = "make one with `followspot train whole`, or leave the parameter out"
        raise InputError([Mistake(None, f"{path} holds no trees of whole bodies: {error}", remedy)]) from None
    return trees


def save(trees: Trees, path: Path) -> None:
    """Write a file of trees."""
    named = {"tree_feature": trees.feature.astype(np.uint16), "tree_threshold": trees.threshold}
    np.savez_compressed(path, allow_pickle=False, **named, tree_leaf=trees.leaf)
