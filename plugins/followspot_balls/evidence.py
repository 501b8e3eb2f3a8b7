"""What candidates are worth as evidence of a lost target (Jin & Qian 2008, section 3.8)."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates

DOUBTED = 0.5
"""Worth of a confirmed candidate that is not evident by itself."""


def recovery_credit(candidates: Candidates) -> Array:
    """Worth of each candidate where a lost target may be: (N,), 0 for all but colour-infrared pairs."""
    return np.asarray(candidates.confirmed * np.where(candidates.evident, 1.0, DOUBTED))
