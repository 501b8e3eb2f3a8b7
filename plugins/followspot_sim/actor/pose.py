"""The pose of an actor, and the surface of the body in that pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.actor.body import (
    CHEST,
    FOREARM,
    HEAD,
    PARENT,
    PELVIS,
    PIVOT,
    SHIN,
    THIGH,
    UPPER_ARM,
    Body,
)

CYCLE = 1.35
"""Length of two steps, m."""
REACH, KNEE, SWING, TWIST = 0.42, 0.75, 0.32, 0.07
"""Swing of the thighs, of the knees, of the arms, and of the chest against the hips in a full stride, rad."""
ELBOW = (0.2, 0.2)
"""Bend of the elbows at rest, and its increase when walking, rad."""
ASIDE = 0.03
"""By how much arms hang away from the body, rad."""


@dataclass(frozen=True)
class Stance:
    """The pose of an actor at one time; angles in rad as in `followspot.people`.

    x, y: m; heading: of the chest; pan, tilt: of the head; stride: 0 standing to 1 walking; phase: of the
    steps, rad.
    """

    x: float
    y: float
    heading: float
    pan: float
    tilt: float
    stride: float
    phase: float


def posed(body: Body, stance: Stance) -> Array:
    """The surface of the body in the room, (V, 3) m; its lowest foot stands on the floor."""
    motion, mesh = motions(stance), body.mesh
    share = mesh.weight[:, None, None]
    each = share * motion[mesh.bone[:, 0]] + (1 - share) * motion[mesh.bone[:, 1]]
    moved = np.matmul(each[:, :, :3], mesh.vertex[:, :, None])[:, :, 0] + each[:, :, 3]
    moved *= body.scale
    moved += [stance.x, stance.y, -moved[:, 2].min()]
    return np.asarray(moved)


def motions(stance: Stance) -> Array:
    """Rotation and shift of every bone from the rest pose, (11, 3, 4), m; the pelvis stays in its place."""
    rotation = _rotations(stance)
    place = np.zeros((len(PARENT), 3))
    for bone in range(1, len(PARENT)):
        parent = PARENT[bone]
        place[bone] = place[parent] + rotation[parent] @ (PIVOT[bone] - PIVOT[parent])
    shift = place - np.einsum("bij,bj->bi", rotation, PIVOT)
    return np.concatenate([rotation, shift[:, :, None]], axis=2)


def _rotations(stance: Stance) -> Array:
    """Of every bone from the rest pose into the room, (11, 3, 3)."""
    swing = stance.stride * np.sin(stance.phase)
    turn = TWIST * swing
    rotation = np.empty((len(PARENT), 3, 3))
    rotation[CHEST] = about_z(stance.heading)
    rotation[PELVIS] = about_z(stance.heading - 2 * turn)
    rotation[HEAD] = rotation[CHEST] @ about_z(stance.pan) @ about_y(-stance.tilt)
    for side, sign in enumerate((1, -1)):
        lift = max(0.0, sign * np.cos(stance.phase)) * stance.stride
        arm = about_x(sign * ASIDE) @ about_y(SWING * sign * swing)
        rotation[UPPER_ARM[side]] = rotation[CHEST] @ arm
        elbow = ELBOW[0] + ELBOW[1] * stance.stride * (1 - sign * np.sin(stance.phase)) / 2
        rotation[FOREARM[side]] = rotation[UPPER_ARM[side]] @ about_y(-elbow)
        rotation[THIGH[side]] = rotation[PELVIS] @ about_y(-REACH * sign * swing - 0.15 * lift)
        rotation[SHIN[side]] = rotation[THIGH[side]] @ about_y(0.04 + KNEE * lift)
    return rotation


def about_x(angle: float) -> Array:
    """Turn left towards up, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_y(angle: float) -> Array:
    """Turn up towards the front, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def about_z(angle: float) -> Array:
    """Turn the front to the left, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
