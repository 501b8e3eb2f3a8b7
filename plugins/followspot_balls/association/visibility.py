"""Whether each view shows a ball: who stands before a camera stays there for a while.

A hidden Markov chain for each ball and camera, with the states hidden and shown (Rabiner 1989, the forward
step): a ball that a camera did not see is hardly contradicted by not being seen there again, and a blob that
turns up in such a view is hardly believed.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def updated(shown: Array, ratio: Array, inside: Array) -> Array:
    """Probabilities that views show balls, after their blobs are known.

    shown: probabilities before; ratio: densities of the blobs as the balls over those of whatever else they
    may be; inside: bool, whether the picture contains the ball's place: else nothing was learnt.
    """
    joint = shown * ratio
    return np.asarray(np.where(inside, joint / (1.0 - shown + joint), shown))


def predicted(shown: Array, usual: float, persistence: float) -> Array:
    """Probabilities one step later. usual: in the long run; persistence: correlation of successive steps."""
    return np.asarray(usual + persistence * (shown - usual))
