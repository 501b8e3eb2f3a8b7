"""Joints and features of actors as pose networks name them: those of COCO."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_sim.actor.body import FOREARM, HEAD, HIP, SHIN, SHOULDER, THIGH, UPPER_ARM, Body
from followspot_sim.actor.pose import Stance, motions

_CENTRE = ("nose", HEAD, (0.165, 0.0, 1.60))
_PAIRS = (
    ("eye", (HEAD, HEAD), (0.135, 0.032, 1.632)),
    ("ear", (HEAD, HEAD), (0.034, 0.078, 1.62)),
    ("shoulder", UPPER_ARM, (0.0, SHOULDER, 1.40)),
    ("elbow", UPPER_ARM, (-0.01, 0.215, 1.12)),
    ("wrist", FOREARM, (0.0, 0.237, 0.86)),
    ("hip", THIGH, (0.0, HIP, 0.92)),
    ("knee", THIGH, (0.0, 0.095, 0.50)),
    ("ankle", SHIN, (-0.012, 0.10, 0.09)),
)
"""Name, bones of the left and the right one, and place of the left one in the rest pose, m."""
_EACH = (
    _CENTRE,
    *(
        (f"{side}_{name}", bones[row], (x, y * (1 - 2 * row), z))
        for name, bones, (x, y, z) in _PAIRS
        for row, side in enumerate(("left", "right"))
    ),
)
NAMES = tuple(name for name, _, _ in _EACH)
"""Of the 17 landmarks, in COCO's order."""
_BONE = np.array([bone for _, bone, _ in _EACH])
_PLACE = np.array([place for _, _, place in _EACH])


def landmarks(body: Body, stance: Stance, surface: Array) -> Array:
    """Landmarks of a person in the room, (17, 3) m. surface: (V, 3) m, of the same pose."""
    motion, mesh, top = motions(stance), body.mesh, body.top[0]
    share = mesh.weight[top]
    own = share * motion[mesh.bone[top, 0]] + (1 - share) * motion[mesh.bone[top, 1]]
    origin = surface[top] - body.scale * (own[:, :3] @ mesh.vertex[top] + own[:, 3])
    moved = (motion[_BONE, :, :3] @ _PLACE[..., None])[..., 0] + motion[_BONE, :, 3]
    return np.asarray(body.scale * moved + origin)
