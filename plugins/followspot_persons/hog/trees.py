"""Boosted trees that judge windows: each asks for one feature, then for one of two others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array

ROWS = 512
"""Windows that are judged at once, which bounds memory."""


@dataclass(frozen=True, eq=False)
class Trees:
    """T trees of two levels. A feature above its threshold leads to the right."""

    feature: Array
    """(T, 3) intp: numbers of the features of the root, of its left and of its right child."""
    threshold: Array
    """(T, 3) f4."""
    leaf: Array
    """(T, 4) f4 log-odds, from left to right."""


def log_odds(trees: Trees, features: Array) -> Array:
    """The sum of all trees for windows: (N, D) f4 -> (N,)."""
    tree = np.arange(len(trees.leaf))
    total = np.zeros(len(features))
    for start in range(0, len(features), ROWS):
        rows = features[start : start + ROWS]
        right = (rows[:, trees.feature[:, 0]] > trees.threshold[:, 0]).astype(np.intp)
        asked = np.take_along_axis(rows, trees.feature[tree, 1 + right], axis=1)
        place = 2 * right + (asked > trees.threshold[tree, 1 + right])
        total[start : start + ROWS] = trees.leaf[tree, place].sum(axis=1)
    return total


def check(trees: Trees, features: int) -> None:
    """Raises ValueError if a shape is wrong, a number is not finite, or a feature is not one of so many."""
    count = trees.leaf.shape[:1]
    for name, columns in (("feature", 3), ("threshold", 3), ("leaf", 4)):
        array = getattr(trees, name)
        if array.shape != (*count, columns):
            raise ValueError(f"tree_{name} has shape {array.shape}, not {(*count, columns)}")
        if not np.isfinite(array).all():
            raise ValueError(f"tree_{name} holds numbers that are not finite")
    if np.any((trees.feature < 0) | (trees.feature >= features)):
        raise ValueError(f"tree_feature holds numbers of features beyond 0 to {features - 1}")
