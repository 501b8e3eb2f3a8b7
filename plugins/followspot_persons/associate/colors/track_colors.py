"""Colours of tracked bodies: a histogram of the torso for each camera, learnt in full view."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.colors.torso_colors import BINS, log_ratios

LEARNING_RATE = 0.1
"""Share of a new picture in a histogram."""
MINIMUM_VISIBLE = 0.7
"""Visible share of a body from which its colours are learnt."""


def unknown_colors(bodies: int, cameras: int) -> Array:
    """Histograms of bodies that no camera has seen, (M, C, BINS)."""
    return np.full((bodies, cameras, BINS), np.nan)


def initial_colors(cameras: int, camera: Array, colors: Array) -> Array:
    """Histograms (1, C, BINS) of a new body. camera: (V,), colors: (V, BINS), of its detections."""
    found = unknown_colors(1, cameras)
    found[0, camera] = colors
    return found


def color_log_ratios(known: Array, camera: int, colors: Array) -> Array:
    """Log-likelihood ratios (M, N): detections of a camera, (N, BINS), have colours of bodies (M, C, BINS).

    A body that this camera has not seen yet is compared by the mean of the other cameras.
    """
    own = known[:, camera]
    seen = np.isfinite(known[..., :1])
    total = np.where(seen, known, 0.0).sum(axis=1)
    number = seen.sum(axis=1)
    mean = np.where(number > 0, total / np.maximum(number, 1), np.nan)
    return log_ratios(np.where(np.isfinite(own), own, mean)[:, None], colors[None])


def updated_colors(known: Array, rows: Array, camera: int, colors: Array, visible: Array) -> Array:
    """Histograms after detections (K, BINS) of these rows. visible: (K,) shares of the bodies in view."""
    clear = np.isfinite(colors[:, 0]) & (visible >= MINIMUM_VISIBLE)
    rows, new = rows[clear], colors[clear]
    before = known[rows, camera]
    found = known.copy()
    found[rows, camera] = np.where(np.isfinite(before), before + LEARNING_RATE * (new - before), new)
    return found
