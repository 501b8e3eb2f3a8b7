"""Detection probability of each ball in each view: people who stand before a camera stay for a while.

A hidden Markov chain for each ball and camera, with the states hidden and visible (Rabiner 1989, the forward
step): if a camera has not detected a ball, a further missed detection says little against the ball, and a
blob that appears in such a view says little for it.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def updated(detection: Array, ratio: Array, in_picture: Array) -> Array:
    """Detection probabilities after the blobs of the views are known.

    detection: probabilities before; ratio: densities of the blobs as the balls over those of whatever else
    they may be; in_picture: bool, whether the picture contains the ball's position: else nothing was learnt.
    """
    joint = detection * ratio
    return np.asarray(np.where(in_picture, joint / (1.0 - detection + joint), detection))


def predicted(detection: Array, usual: float, persistence: float) -> Array:
    """Probabilities one step later. usual: in the long run; persistence: correlation of successive steps."""
    return np.asarray(usual + persistence * (detection - usual))
