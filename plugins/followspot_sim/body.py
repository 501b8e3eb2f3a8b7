"""People as capsules: a pose per person, and the limbs that follow from it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot_sim.holding import holding
from followspot_sim.rounds import BAG, ROUND, SWITCH, WALK, Round, smoothstep

PARTS = (
    "leg", "leg", "torso", "bag", "head", "arm", "arm", "forearm", "forearm", "badge",
)  # fmt: skip
"""Limbs of one person; the badge is a scrap of reflecting cloth that shines in infrared."""
RADII = np.array([0.08, 0.08, 0.17, 0.13, 0.11, 0.055, 0.055, 0.045, 0.045, 0.02])
"""Radius of each limb, m."""
LEGS, ARMS, FOREARMS = slice(0, 2), slice(5, 7), slice(7, 9)
TORSO, BAG_PART, HEAD_PART, BADGE = (PARTS.index(part) for part in ("torso", "bag", "head", "badge"))
"""Their indices in PARTS, left before right."""
SIDES = np.array([1.0, -1.0])
"""Left and right."""
ASIDE = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
"""Directions to the left and right: forward, left, up."""
FEET = np.array([[0.1, 0.08], [-0.1, 0.08]])
"""Feet beside and above the middle of the ground, m."""
ELBOW_SAG = np.array([0.0, 0.0, 0.08])
"""Elbows below the middle between shoulder and hand, m."""
BAG_ENDS = np.array([[0, 0, -0.06], [0, 0, 0.04]])
"""Ends of the bag about its centre, m."""
HIP, TRUNK = 0.92, 0.5
"""Height of the hip, and length from there to the neck, m."""
HIP_HALF, SHOULDER_HALF = 0.09, 0.2
"""Half the distance between the legs at the hip, and between the shoulders, m."""
NECK, HEAD = 0.05, 0.24
"""End of the torso below the neck, and middle of the head above it, m."""
BADGE_UP, BADGE_ASIDE = 0.1, 0.14
"""The badge above the neck and to the left, m."""
BOW_LEAN, BOW_BACK, BOW_DOWN = 1.1, 0.1, 0.3
"""A full bow: angle of the trunk, rad, and how far the hip goes back and down, m."""
STRIDE, STRIDE_RATE = 0.22, 1.4
"""Reach of a foot before the body at a pace of 1 m, m, and strides a second."""
SETTLE = 0.05
"""Time that hands rest before a ball changes hands, after that, and at the end of a round, s."""
CARRY, CARRY_SWAY = np.array([0.38, 0.27, 1.08]), np.array([0.05, 0.03, 0.1])
"""Idle hands before the body: forward, aside and up, and how far they sway, m."""
CARRY_RATE = np.array([3.8, 2.3, 2.8])
"""Rates of this sway, rad/s."""


@dataclass(frozen=True, eq=False)
class Pose:
    """How P people stand.

    base: (P, 2) m; heading: (P,) rad; bow: (P,) 0 to 1; stride: (P,) m; hands: (P, 2, 3) m;
    ball_from_hand: (P, 2, 3) m, in the frames of the people.
    """

    base: Array
    heading: Array
    bow: Array
    stride: Array
    hands: Array
    ball_from_hand: Array

    def in_room(self, local: Array) -> Array:
        """Points in the frames of the people, (P, ..., 3) forward, left, up in m, in the room."""
        shape = (-1, *[1] * (local.ndim - 2))
        c, s = np.cos(self.heading).reshape(shape), np.sin(self.heading).reshape(shape)
        room = np.empty(local.shape)
        room[..., 0] = self.base[:, 0].reshape(shape) + c * local[..., 0] - s * local[..., 1]
        room[..., 1] = self.base[:, 1].reshape(shape) + s * local[..., 0] + c * local[..., 1]
        room[..., 2] = local[..., 2]
        return room

    def held(self, person: int, hand: int) -> Array:
        """Centre of a ball in that hand, (3,) m."""
        c, s = np.cos(self.heading[person]), np.sin(self.heading[person])
        x, y, z = self.ball_from_hand[person, hand]
        return np.asarray(self.hands[person, hand] + [c * x - s * y, s * x + c * y, z])

    def bags(self) -> Array:
        """Centre of each person's bag, (P, 3) m; it is lower if the body bows."""
        local = np.tile(BAG, (len(self.base), 1))
        local[:, 2] -= BOW_DOWN * self.bow
        return self.in_room(local)


def pose(act: Round, u: float, time: float) -> Pose:
    """The people at `u` seconds of a round, `time` seconds of the performance."""
    people = len(act.start)
    s = smoothstep(u / WALK)
    turn = np.mod(act.end[:, 2] - act.start[:, 2] + np.pi, 2 * np.pi) - np.pi
    weight = float(smoothstep((u - WALK) / (SWITCH - WALK - SETTLE)))
    if u > SWITCH:
        weight = 1.0 - float(smoothstep((u - SWITCH - SETTLE) / (ROUND - SWITCH - SETTLE)))
    walk = act.end[:, :2] - act.start[:, :2]
    pace = np.hypot(walk[:, 0], walk[:, 1]) * float(4 * s * (1 - s))
    carried, ball_from_hand = holding(_carry(people, time), act, u)
    at_rest = Pose(
        base=act.start[:, :2] + s * walk,
        heading=act.start[:, 2] + s * turn,
        bow=act.bow * weight,
        stride=STRIDE * np.minimum(pace, 1) * np.sin(2 * np.pi * STRIDE_RATE * time + np.arange(people)),
        hands=np.zeros((people, 2, 3)),
        ball_from_hand=ball_from_hand,
    )
    carried = at_rest.in_room(carried)
    reached = np.where(np.isnan(act.reach), carried, act.reach)
    hands = carried + weight * (reached - carried)
    return replace(at_rest, hands=hands)


def _carry(people: int, time: float) -> Array:
    """Positions of idle hands: in front of the body, swaying. (P, 2, 3), local, m."""
    phase = 1.7 * np.arange(people)[:, None] + 2.9 * np.arange(2)
    local = np.empty((people, 2, 3))
    for axis, phases in enumerate((phase, phase, 2 * phase)):
        local[..., axis] = CARRY[axis] + CARRY_SWAY[axis] * np.sin(CARRY_RATE[axis] * time + phases)
    local[..., 1] *= SIDES
    return local


def trunk(bow: Array) -> tuple[Array, Array]:
    """Hips of the people and directions of their backs, (P, 3) m and unit vectors in their own frames."""
    lean = BOW_LEAN * bow
    hip, up = np.zeros((2, len(bow), 3))
    hip[:, 0], hip[:, 2] = -BOW_BACK * bow, HIP - BOW_DOWN * bow
    up[:, 0], up[:, 2] = np.sin(lean), np.cos(lean)
    return hip, up


def limbs(p: Pose) -> Array:
    """End points of all capsules, person by person in the order of PARTS: (P * 10, 2, 3) m."""
    hip, up = trunk(p.bow)
    neck = hip + TRUNK * up
    ends = np.zeros((len(p.base), len(PARTS), 2, 3))
    ends[:, LEGS, 0] = hip[:, None] + HIP_HALF * ASIDE
    ends[:, LEGS, 1, 0] = SIDES * p.stride[:, None]
    ends[:, LEGS, 1, 1:] = FEET
    ends[:, ARMS] = (neck[:, None] + SHOULDER_HALF * ASIDE)[:, :, None]
    ends[:, TORSO, 0], ends[:, TORSO, 1] = hip, neck - NECK * up
    ends[:, HEAD_PART] = (neck + HEAD * up)[:, None]
    ends[:, BADGE] = (neck + BADGE_UP * up + BADGE_ASIDE * ASIDE[0])[:, None]
    placed = p.in_room(ends)
    elbows = (placed[:, ARMS, 0] + p.hands) / 2 - ELBOW_SAG
    placed[:, ARMS, 1] = placed[:, FOREARMS, 0] = elbows
    placed[:, FOREARMS, 1] = p.hands
    placed[:, BAG_PART] = p.bags()[:, None] + BAG_ENDS
    return placed.reshape(-1, 2, 3)
