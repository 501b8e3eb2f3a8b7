"""Evidence of lost targets in candidates (Jin & Qian 2008, section 3.8)."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates
from followspot_balls.pairs.three_views import threefold

DOUBTED = 0.5
"""Weight of a confirmed candidate that is not evident."""


def recovery_credit(candidates: Candidates) -> Array:
    """Weight of each candidate as evidence of a lost target: (N,), 0 unless it is confirmed."""
    return np.asarray(candidates.confirmed * np.where(candidates.evident, 1.0, DOUBTED))


def appearing(candidates: Candidates, lost: Array) -> Array:
    """Which candidates belong to three views of a lost target that all make pairs: (N, T) bool.

    At least one of the three pairs is evident. The views may agree less well than usual, because only parts
    of an appearing ball are visible, and their centres are not that of the ball.
    lost: (T,) bool, without forecast.
    """
    sought = candidates.targets & lost
    return threefold(candidates, sought, sought & candidates.evident[:, None])
