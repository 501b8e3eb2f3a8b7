"""Balls that are forecast side by side in a picture, of which one may cover a part of the other."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array

BESIDE = 1.25
"""Distance of two outlines' centres over the sum of their radii up to which one ball may cover a part of the
other: the quarter is for errors of the forecasts, and for a blob's blurred edge."""


def beside(center: Array, ball: Array) -> Array:
    """Which targets are forecast beside another one: (C, T) bool.

    center: (C, T, 2) px, in the pictures of C views; ball: (C, T) px, radii; NaN without a forecast.
    """
    apart = center[:, :, None] - center[:, None]
    reach = BESIDE * (ball[:, :, None] + ball[:, None])
    near = np.vecdot(apart, apart) < reach * reach
    return np.asarray(near.sum(axis=2) > 1)  # each is near itself
