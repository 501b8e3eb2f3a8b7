"""Left and right, which networks exchange for some time: hidden Markov models of each camera and part.

A part is a group of joints that have two sides. Whether a camera's labels of a part are exchanged is a
Markov chain of two states, filtered forwards (Rabiner 1989) by two hypotheses at once: that the sides of the
body itself are as they are tracked, or reversed. The likelihoods of both hypotheses over time give the
log-odds that they are reversed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from followspot import Array

SHARE, DURATION = 0.02, 0.6
"""Share of the time in which a camera's labels are exchanged, and the mean duration of one exchange, s."""
SURE = 12.0
"""Bound of all log-odds, so that further evidence can reverse them."""
PARTS = (
    ("eye", "ear"),
    ("shoulder",),
    ("elbow", "wrist", "hand", "thumb", "index", "pinky"),
    ("hip",),
    ("knee", "ankle", "heel", "toe", "big_toe", "small_toe", "foot"),
)
"""How the names of joints begin, after the side, that are exchanged together."""
_OTHER = {"left": "right", "right": "left"}


@dataclass(frozen=True, eq=False)
class Sides:
    """Of J joints. mirror: (J,) the same joint of the other side; part: (J, G) 1 for those of each part;
    left: (J,) 1 for those of the left side.
    """

    mirror: Array
    part: Array
    left: Array


@lru_cache(maxsize=8)
def sides_of(joints: tuple[str, ...]) -> Sides:
    """The sides of joints of these names; those without a joint of the other side belong to no part."""
    mirror, part = np.arange(len(joints)), np.zeros((len(joints), len(PARTS)))
    left = np.zeros(len(joints))
    for row, name in enumerate(joints):
        side, _, joint = name.partition("_")
        other = f"{_OTHER.get(side, side)}_{joint}"
        if other != name and other in joints:
            mirror[row], left[row] = joints.index(other), side == "left"
            part[row] = [joint.startswith(words) for words in PARTS]
    return Sides(mirror, part, left)


def unknown(bodies: int, cameras: int) -> tuple[Array, Array]:
    """Log-odds of bodies of which no camera has told anything, as :func:`observed` takes them."""
    usual = float(np.log(SHARE / (1 - SHARE)))
    return np.full((bodies, cameras, len(PARTS), 2), usual), np.zeros((bodies, len(PARTS)))


def predicted(exchanged: Array, seconds: float) -> Array:
    """Log-odds (..., 2) that labels are exchanged some time later."""
    share = SHARE + (_probability(exchanged) - SHARE) * np.exp(-seconds / (DURATION * (1 - SHARE)))
    return np.asarray(np.log(share / (1 - share)))


def observed(exchanged: Array, reversal: Array, ratio: Array) -> tuple[Array, Array]:
    """The log-odds after a picture.

    exchanged: (..., 2) that the labels are exchanged, if the sides of the body are as they are tracked and if
    they are reversed; reversal: (...) that they are; ratio: (...) log-likelihood ratio of the labels being
    those of the other side as tracked.
    """
    likelihood, share = np.exp(ratio), _probability(exchanged)
    kept, turned = share[..., 0], share[..., 1]
    evidence = np.log(turned + (1 - turned) * likelihood) - np.log(1 - kept + kept * likelihood)
    found = exchanged + np.stack([ratio, -ratio], axis=-1)
    return np.clip(found, -SURE, SURE), np.clip(reversal + evidence, -SURE, SURE)


def _probability(odds: Array) -> Array:
    return np.asarray(1 / (1 + np.exp(-odds)))
