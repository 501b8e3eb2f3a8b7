"""Directions of chest and face from the joints of one picture: order of left and right, and the nose.

The numbers are least absolute deviations over 991 crops of 12 rendered people with known directions, as
MoveNet MultiPose sees them; tools/learn_directions.py prints them. With each person left out, the numbers of
the others find its chest within 8 degrees at the median, its face within 10.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.geometry import wrap
from followspot_persons.hog.model import DIRECTIONS, trusted

NECK = 0.6
"""Sigma of the head's direction relative to the chest, rad."""
TRUST = ((0.7, 0.1), (0.3, 0.1))
"""Factor of the log-likelihoods and share of gross errors, for chest and face: the maximum likelihood for
people who were left out when the tables were learnt (cross-validation)."""


@dataclass(frozen=True)
class Cue:
    """How far the middle of some joints is to the right of that of others, in heights of the upper body.

    With the chest turned by t and the face by h (0 faces the camera, positive to the own left) it is
    facing_chest cos t + side_chest sin t + facing_face cos h + side_face sin h, with one sigma.
    """

    joints: tuple[str, ...]
    others: tuple[str, ...]
    sigma: float
    facing_chest: float = 0.0
    side_chest: float = 0.0
    facing_face: float = 0.0
    side_face: float = 0.0


EARS = ("left_ear", "right_ear")
SHOULDERS = ("left_shoulder", "right_shoulder")
CUES = (
    Cue(SHOULDERS[:1], SHOULDERS[1:], 0.052, facing_chest=0.580),
    Cue(("left_hip",), ("right_hip",), 0.047, facing_chest=0.366),
    Cue(EARS[:1], EARS[1:], 0.035, facing_face=0.208),
    Cue(("nose",), EARS, 0.030, side_face=0.151),
    Cue(("nose",), SHOULDERS, 0.033, side_chest=0.060, side_face=0.158),
)


def shift_of(cue: Cue, joints: Sequence[str], pixel: Array, height: Array) -> Array:
    """The offset that a cue is about, (P,). joints: J names; pixel: (P, J, 2) px; height: (P,) px."""
    rows, others = ([joints.index(name) for name in names] for names in (cue.joints, cue.others))
    return np.asarray((pixel[:, rows, 0].mean(axis=1) - pixel[:, others, 0].mean(axis=1)) / height)


def headings(
    joints: Sequence[str], pixel: Array, found: Array, height: Array, cues: Sequence[Cue] = CUES
) -> tuple[Array, Array]:
    """Log-likelihoods of the directions of chest and face, (P, DIRECTIONS) each, as in `Boxes`.

    joints: J names; pixel: (P, J, 2) px; found: (P, J) bool; height: (P,) px of the upper bodies. A direction
    that no joint speaks of is as likely as any other.
    """
    known = [cue for cue in cues if {*cue.joints, *cue.others} <= set(joints)]
    angle = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    chest, face = angle[:, None], angle[None]
    value = np.tile(-0.5 * (wrap(face - chest) / NECK) ** 2, (len(pixel), 1, 1))
    for cue in known:
        rows = [joints.index(name) for name in (*cue.joints, *cue.others)]
        counts = np.asarray(found[:, rows].min(axis=1))
        shift = shift_of(cue, joints, pixel, height)
        expected = cue.facing_chest * np.cos(chest) + cue.side_chest * np.sin(chest)
        expected = expected + cue.facing_face * np.cos(face) + cue.side_face * np.sin(face)
        error = (np.where(counts, shift, 0.0)[:, None, None] - expected) / cue.sigma
        value -= 0.5 * counts[:, None, None] * np.square(error)
    tables = (_log_sum(value, 2), _log_sum(value, 1))
    torso, head = (trusted(table, *trust) for table, trust in zip(tables, TRUST, strict=True))
    return torso, head


def _log_sum(value: Array, axis: int) -> Array:
    """Logarithm of the sum of exponentials along an axis."""
    most = value.max(axis=axis, keepdims=True)
    return np.asarray((most + np.log(np.exp(value - most).sum(axis=axis, keepdims=True))).squeeze(axis))
