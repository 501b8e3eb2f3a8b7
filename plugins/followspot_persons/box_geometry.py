"""Distances of boxes, boxes on bodies, and points that are carried from one box to another."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.panorama import short_way

ARMS, SHOULDERS = 0.5, 1 / 3
"""Largest distance of arms and of shoulders from the middle of a body, in heights of its box."""


def box_distance(expected: Array, detected: Array, turn: int = 0) -> Array:
    """Distance of boxes' middles and of their sizes, in heights of the detected box, (K, N).

    expected: (K, 4) px x0 y0 x1 y1; detected: (N, 4); turn: columns of a full turn, 0 for none.
    """
    return np.asarray(np.hypot(*box_offsets(expected, detected, turn)))


def box_offsets(expected: Array, detected: Array, turn: int = 0) -> tuple[Array, Array]:
    """Distance of boxes' middles, in heights of the detected box, and logarithm of their sizes' ratio, (K, N)
    each; arguments as of :func:`box_distance`.
    """
    a, b = expected[:, None], detected[None]
    height = np.maximum(b[..., 3] - b[..., 1], 1e-6)
    across = (a[..., 0] + a[..., 2] - b[..., 0] - b[..., 2]) / 2
    across = short_way(across, turn)
    down = (a[..., 1] + a[..., 3] - b[..., 1] - b[..., 3]) / 2
    size = np.log(np.maximum(a[..., 3] - a[..., 1], 1e-6) / height)
    return np.asarray(np.hypot(across, down) / height), size


def on_body(boxes: Array, body: Array, turn: int = 0, certainty: Array | float = 0.0) -> Array:
    """Whether boxes are parts of boxed bodies: their middle is on the body or up to a height below.

    What surely is an upper body is no arm: its middle must be between the shoulders. boxes: (N, 4) px; body:
    (K, 4) px, upper bodies; turn: columns of a full turn, 0 for none; certainty: (N,) that a box spans an
    upper body, 0 to 1. Returns (N,).
    """
    half = ARMS + np.reshape(certainty, (-1, 1)) * (SHOULDERS - ARMS)
    a, b = boxes[:, None], body[None]
    height = b[..., 3] - b[..., 1]
    across = (a[..., 0] + a[..., 2] - b[..., 0] - b[..., 2]) / 2
    across = short_way(across, turn)
    down = (a[..., 1] + a[..., 3]) / 2 - b[..., 1]
    return np.asarray(((np.abs(across) < half * height) & (down > 0) & (down < 2 * height)).any(axis=1))


def carried(points: Array, source: Array, target: Array) -> Array:
    """Points (F, 2) px of one box as they would lie in another: shifted, and scaled by the boxes' heights.

    source, target: (4,) px x0 y0 x1 y1; their widths do not count, for a detector's are all alike.
    """
    scale = (target[3] - target[1]) / max(source[3] - source[1], 1e-6)
    middle = np.array([(source[0] + source[2]) / 2, source[1]])
    return np.asarray((points - middle) * scale + [(target[0] + target[2]) / 2, target[1]])
