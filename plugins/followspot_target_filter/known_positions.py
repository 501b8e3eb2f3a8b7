"""Positions with known coordinates: a NaN is no measurement, and would spoil the track that it updates."""

from __future__ import annotations

import math

import numpy as np

from followspot.tracking import Positions


def known_positions(positions: Positions) -> Positions:
    """The positions with finite coordinates; the same message if all are."""
    if math.isfinite(positions.xyz.sum()):
        return positions
    return positions.where(np.asarray(np.isfinite(positions.xyz).all(axis=1)))


def unknown_positions(count: int) -> str:
    """The warning that this many positions were left out; "" for none."""
    if not count:
        return ""
    return f"left out {count} positions with NaN or infinite coordinates: correct the stage that gives them"
