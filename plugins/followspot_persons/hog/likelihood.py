"""The likelihood of a detector's boxes and headings given poses (section 3.2)."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.panorama import short_way

NOTHING = 1e-3
"""Likelihood of a pose without a box; not 0, because the combination multiplies."""


def box_likelihood(expected: Array, detected: Array, width: float, turn: int = 0) -> Array:
    """F^HOG: overlap of the rows times a Gaussian of the distance of the columns, for the nearest box.

    Areas do not count, for the boxes of a detector have all the same ratio of sides.
    expected: (P, 4) px x0 y0 x1 y1; detected: (N, 4) px; width: one sigma of the distance, in heights of the
    detected box; turn: columns of a full turn, 0 for none. Returns (P,), 0 to 1.
    """
    if len(detected) == 0:
        return np.full(len(expected), NOTHING)
    expected, detected = expected[:, None], detected[None]
    top = np.maximum(expected[..., 1], detected[..., 1])
    bottom = np.minimum(expected[..., 3], detected[..., 3])
    union = np.maximum(expected[..., 3], detected[..., 3]) - np.minimum(expected[..., 1], detected[..., 1])
    overlap = np.maximum(bottom - top, 0) / np.maximum(union, 1e-6)
    apart = (expected[..., 0] + expected[..., 2] - detected[..., 0] - detected[..., 2]) / 2
    apart = short_way(apart, turn) / np.maximum(detected[..., 3] - detected[..., 1], 1e-6)
    fit = overlap * np.exp(-0.5 * (apart / width) ** 2)
    return np.asarray(np.maximum(np.nan_to_num(fit).max(axis=1), NOTHING))


def heading_log_likelihood(table: Array, heading: Array) -> Array:
    """Log-likelihood of headings from a table of directions, interpolated linearly; its maximum is 0.

    table: (B,) for 2 pi i / B each; heading: (P,) rad relative to the camera. Returns (P,).
    """
    if len(table) == 0:
        return np.zeros(len(heading))
    place = heading * (len(table) / (2 * np.pi)) % len(table)
    low = place.astype(np.intp) % len(table)
    share = place - np.floor(place)
    relative = table - table.max()
    return np.asarray(relative[low] * (1 - share) + relative[(low + 1) % len(table)] * share)
