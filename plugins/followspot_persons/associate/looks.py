"""What tracked bodies look like: a histogram of the torso for each camera, learnt in full view."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.torso_colors import BINS, log_ratios

RATE = 0.1
"""Share of a new picture in a histogram."""
CLEAR = 0.7
"""Visible share of a body from which its colours are learnt."""


def unseen(bodies: int, cameras: int) -> Array:
    """Histograms of bodies that no camera has seen, (M, C, BINS)."""
    return np.full((bodies, cameras, BINS), np.nan)


def first(cameras: int, camera: Array, colors: Array) -> Array:
    """Histograms (1, C, BINS) of a new body. camera: (V,), colors: (V, BINS), of its detections."""
    found = unseen(1, cameras)
    found[0, camera] = colors
    return found


def agreement(looks: Array, camera: int, colors: Array) -> Array:
    """Log-likelihood ratios (M, N) that detections of a camera, (N, BINS), look like bodies (M, C, BINS).

    A body that this camera has not seen yet is compared as the mean of the other cameras has it.
    """
    own = looks[:, camera]
    known = np.isfinite(looks[..., :1])
    total = np.where(known, looks, 0.0).sum(axis=1)
    number = known.sum(axis=1)
    mean = np.where(number > 0, total / np.maximum(number, 1), np.nan)
    return log_ratios(np.where(np.isfinite(own), own, mean)[:, None], colors[None])


def learnt(looks: Array, rows: Array, camera: int, colors: Array, visible: Array) -> Array:
    """Histograms after detections (K, BINS) of these rows. visible: (K,) shares of the bodies in view."""
    clear = np.isfinite(colors[:, 0]) & (visible >= CLEAR)
    rows, new = rows[clear], colors[clear]
    before = looks[rows, camera]
    found = looks.copy()
    found[rows, camera] = np.where(np.isfinite(before), before + RATE * (new - before), new)
    return found
