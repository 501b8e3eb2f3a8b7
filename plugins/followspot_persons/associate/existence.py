"""Existence of tracked bodies as log-odds, which rise with detections and fall with missed ones.

That is the integrated probabilistic data association (Bar-Shalom, Willett & Tian 2011, section 3.6).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_persons.associate.multi_view.views import View

MINIMUM_ODDS, MAXIMUM_ODDS = -8.0, 10.0
"""Bounds of the log-odds, so that further evidence can reverse them."""
PERSISTENCE = 0.1
"""Time for which a network misses the same person, s."""
SHRUNK = 0.8
"""Width of a body over that of the box about it: what is behind the edge of the box is seen."""
NEARER = 0.2
"""Difference of depth from which a body hides another, m."""
CONTRADICTED = -3.0
"""Sum of the misses of other cameras from which the detection of one alone shows no body."""
LEAST_VISIBLE = 0.1
"""Share of a body that is visible although nearer ones seem to hide it: boxes are wider than bodies."""
_ACROSS, _DOWN = np.meshgrid([0.25, 0.5, 0.75], (np.arange(7) + 0.5) / 7)
_GRID = np.column_stack([_ACROSS.ravel(), _DOWN.ravel()])


class OddsLimits(NamedTuple):
    """Log-odds of a new body without its detections; what a detection adds to a tracked body's at most."""

    initial: float
    detection: float


@dataclass(frozen=True, eq=False)
class ExistenceEvidence:
    """Evidence of the cameras of one set for M bodies. gain, loss: (M,) sums of log-odds; views: (M,) cameras
    that detected each.
    """

    gain: Array
    loss: Array
    views: Array

    @property
    def missed(self) -> Array:
        """Whether no camera detected a body, or one alone and others that see it did not, (M,)."""
        contradicted = (self.views == 1) & (self.loss < CONTRADICTED)
        return np.asarray((self.views == 0) | contradicted)

    def change(self, independent: float = 1.0) -> Array:
        """Change of the log-odds, (M,). One camera alone is no evidence: any false detection has a body that
        fits it. independent: share of the misses that are independent of those before.
        """
        return np.where(self.views > 1, self.gain, 0.0) + independent * self.loss


def independence(seconds: float) -> float:
    """Share of misses that are independent of those in the set of pictures some seconds before."""
    return min(1.0, max(seconds, 0.0) / PERSISTENCE)


def visible_shares(box: Array, depth: Array, confirmed: Array, view: View) -> Array:
    """Share of each body, (M,), that is in the picture and hidden by no nearer body.

    box: (M, 4) px about the bodies, NaN if they are not in front; depth: (M,) m; confirmed: (M,) bool, the
    bodies that hide others. Others may not exist, and then they would keep detections from a real body.
    """
    size = box[:, None, 2:] - box[:, None, :2]
    point = box[:, None, :2] + size * _GRID
    inside = ((point > 0) & (point < view.size)).all(axis=-1)
    middle, half = (box[:, 0] + box[:, 2]) / 2, SHRUNK * (box[:, 2] - box[:, 0]) / 2
    u, v = point[:, :, None, 0], point[:, :, None, 1]
    covered = (np.abs(u - middle) < half) & (v > box[:, 1]) & (v < box[:, 3])
    nearer = (depth < depth[:, None] - NEARER) & confirmed
    hidden = (covered & nearer[:, None]).any(axis=2)
    return np.asarray((inside & ~hidden).mean(axis=1))


def missed_detection(visible: Array, detection: float) -> Array:
    """Change of the log-odds of bodies without a detection. visible: shares; detection: probability that a
    body in full view is detected.
    """
    return np.asarray(np.log1p(-detection * visible))


def log_visibility(visible: Array) -> Array:
    """Logarithm of the probability that bodies are detected, over that of bodies in full view, (M,).

    A detection of a body that others hide is improbable, however well a box fits it. visible: shares.
    """
    return np.asarray(np.log(np.maximum(visible, LEAST_VISIBLE)))
