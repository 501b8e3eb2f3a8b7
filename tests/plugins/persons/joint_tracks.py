"""Joints of bodies that hang their arms."""

from __future__ import annotations

import numpy as np

from followspot_persons.associate.joints.sides import unknown
from followspot_persons.associate.joints.tracks import JointTracks
from followspot_sim.actor.landmarks import NAMES

LEFT, RIGHT = 0.28, 0.26


def bodies(sigma: float, left: float = LEFT, right: float = RIGHT, views: int = 3) -> JointTracks:
    """One body that hangs its arms; upper arms of these lengths. sigma: of all joints, m."""
    joints = len(NAMES)
    xyz = np.zeros((1, joints, 3))
    for side, length, y in (("left", left, 0.2), ("right", right, -0.2)):
        for name, z in (("shoulder", 1.4), ("elbow", 1.4 - length), ("wrist", 1.4 - length - 0.25)):
            xyz[0, NAMES.index(f"{side}_{name}")] = [0.0, y, z]
        for name, z in (("hip", 0.9), ("knee", 0.48), ("ankle", 0.06)):
            xyz[0, NAMES.index(f"{side}_{name}")] = [0.0, y, z]
    place = np.tile(sigma**2 * np.eye(3), (1, joints, 1, 1))
    nothing = np.zeros((1, joints, 3, 3))
    seen = np.full((1, joints), views)
    return JointTracks(xyz, np.zeros_like(xyz), place, nothing, nothing, seen, seen > 0, *unknown(1, 4))
