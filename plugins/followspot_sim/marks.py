"""What people wear beside balls: reflectors that shine in infrared, patches in the colours of the balls."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_sim.body import FOREARMS, LEGS, PARTS, Pose, trunk

MARKS = ("brace", "brace", "brace", "brace", "cuff", "cuff", "band", "band", "disc", "patch", "patch")
"""Marks of one person: braces before the body and behind it, cuffs and thigh bands left before right, a round
reflector on the back; patches on the left shoulder and the chest."""
MARK_RADII = np.array([0.02, 0.02, 0.02, 0.02, 0.05, 0.05, 0.085, 0.085, 0.05, 0.06, 0.06])
"""Radii of these marks, m."""
TRUNK_ENDS = np.array([
    [[0.16, 0.09, 0.12], [0.16, 0.09, 0.42]], [[0.16, -0.09, 0.12], [0.16, -0.09, 0.42]],
    [[-0.16, 0.05, 0.12], [-0.16, 0.05, 0.42]], [[-0.16, -0.05, 0.12], [-0.16, -0.05, 0.42]],
    [[-0.15, 0.0, 0.3], [-0.15, 0.0, 0.3]], [[0.03, 0.18, 0.46], [0.03, 0.18, 0.46]],
    [[0.14, 0.0, 0.36], [0.14, 0.0, 0.36]],
])  # fmt: skip
"""Braces, disc and patches in the frame of the trunk: forward, left, up from the hip; m."""
ON_TRUNK = (0, 1, 2, 3, 8, 9, 10)
CUFF, BAND = np.array([0.72, 0.8]), np.array([0.33, 0.33])
"""Where cuffs and thigh bands begin and end, as shares of the forearm and the leg."""


def marks(p: Pose, limbs: Array) -> Array:
    """End points of all marks, person by person in the order of MARKS: (P * 11, 2, 3) m.

    limbs: (P * 10, 2, 3) m, of these people.
    """
    people = len(p.base)
    own = limbs.reshape(people, len(PARTS), 2, 3)
    hip, up = trunk(p.bow)
    front = np.column_stack([up[:, 2], np.zeros(people), -up[:, 0]])
    left = np.tile([0.0, 1.0, 0.0], (people, 1))
    frame = np.stack([front, left, up], axis=1)
    placed = np.empty((people, len(MARKS), 2, 3))
    placed[:, ON_TRUNK] = p.in_room(hip[:, None, None] + np.einsum("kej,pji->pkei", TRUNK_ENDS, frame))
    placed[:, 4:6] = _along(own[:, FOREARMS], CUFF)
    placed[:, 6:8] = _along(own[:, LEGS], BAND)
    return placed.reshape(-1, 2, 3)


def _along(limbs: Array, share: Array) -> Array:
    """Pieces (P, 2, 2, 3) of limbs (P, 2, 2, 3) m, from one share of their length to the other."""
    start, end = limbs[:, :, :1], limbs[:, :, 1:]
    return np.asarray(start + share[:, None] * (end - start))
