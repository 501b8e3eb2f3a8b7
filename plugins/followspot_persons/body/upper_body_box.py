"""Boxes of upper bodies from joints, by the proportions of upright bodies (Drillis & Contini 1966)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array
from followspot_persons.body.standing import WAIST

HIP = 0.530
"""Height of the hip over that of the whole person."""
LEVELS = {"nose": 0.91, "eye": 0.936, "ear": 0.926, "shoulder": 0.818, "hip": HIP}
"""Height of joints over that of the person; eye, shoulder and hip after Drillis & Contini, nose and ear
between them as in surveys of heads."""
SPREAD = 0.08
"""Distance of the lowest from the highest joint that determines a box, in body heights: face to shoulders."""
SMALLEST = 1.0
"""Height of a box, px."""
RATIO = 2 / 3
"""Width over height of the boxes, as `persons.hog` gives them."""


def level_of(joint: str) -> float:
    """Height of a joint over that of the person; NaN if it does not count."""
    return LEVELS.get(joint.removeprefix("left_").removeprefix("right_"), np.nan)


def upper_bodies(joints: Sequence[str], pixel: Array, weight: Array) -> Array:
    """Boxes from head top to waist, (P, 4) px x0 y0 x1 y1; NaN if the joints do not determine it.

    The rows of joints are a line over their heights on the body, y = top + (1 - level) height, by weighted
    least squares. joints: J names; pixel: (P, J, 2) px; weight: (P, J), 0 for joints that were not found.
    """
    level = np.array([level_of(joint) for joint in joints])
    counting = np.isfinite(level)
    if not counting.any():
        return np.full((len(pixel), 4), np.nan)
    middle = _middle(joints, pixel[..., 0], weight)
    down, weight, pixel = 1 - level[counting], weight[:, counting], pixel[:, counting]
    found = weight > 0
    spread = np.where(found, down, -np.inf).max(axis=1) - np.where(found, down, np.inf).min(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = weight / weight.sum(axis=1, keepdims=True)
        mean_down, mean_row = share @ down, (share * pixel[..., 1]).sum(axis=1)
        apart = down - mean_down[:, None]
        slope = (share * apart * pixel[..., 1]).sum(axis=1) / (share * apart**2).sum(axis=1)
    top = mean_row - mean_down * slope
    height = (1 - WAIST) * slope
    sure = (spread >= SPREAD) & (height >= SMALLEST)
    box = np.column_stack([middle - RATIO / 2 * height, top, middle + RATIO / 2 * height, top + height])
    return np.where(sure[:, None], box, np.nan)


def _middle(joints: Sequence[str], column: Array, weight: Array) -> Array:
    """Column of the body's axis, (P,): between left and right shoulder and hip, or of the only side found.

    column, weight: (P, J).
    """
    pairs = [(f"left_{part}", f"right_{part}") for part in ("shoulder", "hip")]
    index = [[joints.index(name) for name in pair] for pair in pairs if set(pair) <= set(joints)]
    rows = np.array(index, int).reshape(-1, 2)
    place, share = np.asarray(column[:, rows]), np.asarray(weight[:, rows])
    both = np.asarray(share.min(axis=2, keepdims=True) > 0)
    share = np.where(both.any(axis=1, keepdims=True), np.repeat(both, 2, axis=2), share)
    with np.errstate(invalid="ignore"):
        return np.asarray((share * place).sum(axis=(1, 2)) / share.sum(axis=(1, 2)))
