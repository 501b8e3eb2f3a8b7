"""What candidates are worth as evidence of a lost target (Jin & Qian 2008, section 3.8)."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates
from followspot_balls.three_views import threefold

DOUBTED = 0.5
"""Worth of a confirmed candidate that is not evident by itself."""


def recovery_credit(candidates: Candidates) -> Array:
    """Worth of each candidate where a lost target may be: (N,), 0 for all but colour-infrared pairs."""
    return np.asarray(candidates.confirmed * np.where(candidates.evident, 1.0, DOUBTED))


def appearing(candidates: Candidates, lost: Array) -> Array:
    """Which candidates show a lost target to three views that all make pairs with each other: (N, T) bool.

    One of the pairs is evident. Where each of three views confirms both others they may agree less well:
    what appears shows itself in parts, and the centre of a part is not that of the ball.
    lost: (T,) bool, without forecast.
    """
    sought = candidates.targets & lost
    return threefold(candidates, sought, sought & candidates.evident[:, None])
