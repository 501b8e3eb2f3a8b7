"""The upper body of a known person in the foreground, where the detector gives no box.

The detector misses people from unusual sides, in dim light, and when their heads leave the picture. What
differs from the background where a person is expected is the person, unless it is somebody else's.
"""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera
from followspot_persons.body.standing import knows_floor, rise
from followspot_persons.body.upper_body_box import RATIO
from followspot_persons.panorama import full_turn, short_way, turn_of

STEP = 2
"""The foreground is compared at one pixel of so many in each row and column."""
TORSO, HEAD = 0.2, 0.12
"""Half the width of torso and head, in heights of the upper body."""
BESIDE = 0.45
"""Half the width of another person's columns, in heights of its upper body."""
FILLED = 0.5
"""Share of foreground in a torso."""
UP, DOWN = 0.4, 0.5
"""Reach of the search for the head's top, above and below the expected one, in heights of the upper body."""
SMALLEST, LARGEST = 0.7, 1.4
"""Limits of the change of size since the last picture."""
LEVEL = 0.25
"""Height of the head's top over the camera from which its row tells the distance of a known height, m."""


def shares(camera: Camera, mask: Array, boxes: Array) -> Array:
    """Share of foreground in the middle of each box, (K, 4) px -> (K,).

    mask: (H / STEP, W / STEP) bool, foreground.
    """
    found = np.empty(len(boxes))
    for i, (x0, y0, x1, y1) in enumerate(boxes.tolist()):
        rows = slice(max(0, int(y0 / STEP)), max(1, int(np.ceil(y1 / STEP))))
        torso = np.abs(_aside(mask, (x0 + x1) / 2, camera)) <= max(TORSO * (y1 - y0), STEP)
        part = mask[rows][:, torso]
        found[i] = part.mean() if part.size else 0.0
    return found


def without_others(mask: Array, boxes: Array, camera: Camera) -> Array:
    """A mask (H / STEP, W / STEP) without the columns of other people's upper bodies, (K, 4) px."""
    out = mask.copy()
    for x0, y0, x1, y1 in boxes.tolist():
        out[:, np.abs(_aside(mask, (x0 + x1) / 2, camera)) < BESIDE * (y1 - y0)] = False
    return out


def foreground_box(
    camera: Camera, mask: Array, expected: Array, stature: float, reach: float
) -> Array | None:
    """The upper body, (4,) px, that is nearest to where it is expected; None if there is none.

    mask: (H / STEP, W / STEP) bool, foreground; expected: (4,) px, the upper body at its last pose; stature:
    height of the person, m; reach: one sigma of its motion in the picture, px.
    """
    tall = float(expected[3] - expected[1])
    rows = slice(max(0, int(expected[1] / STEP)), max(0, int(expected[3] / STEP)))
    band = mask[rows]
    if not np.isfinite(expected).all() or tall < 4 * STEP or len(band) < 0.3 * tall / STEP:
        return None
    aside = _aside(mask, (expected[0] + expected[2]) / 2, camera)
    filled = _smooth(band.mean(axis=0), int(TORSO * tall / STEP), full_turn(camera))
    near = filled * np.exp(-0.5 * (aside / reach) ** 2)
    best = int(near.argmax())
    if filled[best] < FILLED or abs(aside[best]) > 2 * reach:
        return None
    middle = _centre(band, aside, best, tall)
    head = np.abs(aside - middle) < HEAD * tall
    top = _top(mask[:, head].mean(axis=1), expected[1], tall)
    column = (expected[0] + expected[2]) / 2 + middle
    size = tall if top is None else _size(camera, tall, (column, expected[1], top), stature)
    y0 = float(expected[1]) if top is None else top
    return np.array([column - RATIO / 2 * size, y0, column + RATIO / 2 * size, y0 + size])


def _aside(mask: Array, column: float, camera: Camera) -> Array:
    """Distance of each column of a mask from a column of the picture, px."""
    return short_way(np.arange(mask.shape[1]) * STEP - column, turn_of(camera))


def _smooth(share: Array, half: int, wraps: bool) -> Array:
    """The mean over `half` columns to either side."""
    half = max(1, min(half, (len(share) - 1) // 2))
    padded = np.pad(share, half, mode="wrap" if wraps else "constant")
    return np.convolve(padded, np.full(2 * half + 1, 1 / (2 * half + 1)), mode="valid")


def _centre(band: Array, aside: Array, best: int, tall: float) -> float:
    """Centre of the foreground about a column, px from the expected one."""
    about = np.abs(aside - aside[best]) < 1.5 * TORSO * tall
    return float(np.average(aside[about], weights=band[:, about].sum(axis=0) + 1e-6))


def _top(share: Array, expected: float, tall: float) -> float | None:
    """Row of the head's top, px: the first of several filled rows; None if it lies beyond the picture."""
    first, last = (int((expected + k * tall) / STEP) for k in (-UP, DOWN))
    filled = share[max(first, 0) : max(last, 1)] > FILLED / 2
    height = max(2, int(HEAD * tall / STEP))
    if len(filled) < height:
        return None
    runs = np.lib.stride_tricks.sliding_window_view(filled, height).all(axis=1)
    start = max(first, 0) + int(runs.argmax())
    return float(start * STEP) if runs.any() and start > 0 else None


def _size(camera: Camera, tall: float, place: tuple[float, float, float], stature: float) -> float:
    """Height of the upper body, px, of a known stature (m) if the head's top is seen in another row.

    place: column, and rows of the expected and of the seen top, px.
    """
    column, before, top = place
    above = stature - camera.center[2]
    if not knows_floor(camera) or abs(above) < LEVEL:
        return tall
    then, now = rise(camera, np.array([column, column]), np.array([before, top]))
    if then * above <= 0 or now * above <= 0:
        return tall
    return float(tall * np.clip(now / then, SMALLEST, LARGEST))
