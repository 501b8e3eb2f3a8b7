"""Poses of a board in a camera, and of a camera against another one that sees the same board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Camera
from followspot.geometry import undistort
from followspot.messages import Array
from followspot_calibrate.boards.board import Board
from followspot_calibrate.boards.detection import View
from followspot_calibrate.similarity import Similarity

POOR = 3.0
"""RMS error of a view's pose from which it is no view of the board at all, px."""
NEAR_ANGLE = 0.05
"""Angle between two relative poses that say the same, rad."""
NEAR_SHIFT = 0.05
"""Their distance over the distance to the board."""

MOST_MOMENTS = 300
"""Largest number of shared views of a pair that are compared, evenly spread."""


STILL = Similarity(np.eye(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class BoardPose:
    """A pose from the board to a camera and its error, px RMS; a flat board far away has two such poses."""

    pose: Similarity
    error: float


def board_poses(camera: Camera, view: View, board: Board) -> list[BoardPose]:
    """Poses that explain a view, the best first (Collins & Bartoli 2014); none for a view that is none."""
    xy = undistort(camera, view.pixel)
    corners = board.corners[view.label]
    if not np.isfinite(xy).all():
        return []
    try:
        count, turns, shifts, errors = cv2.solvePnPGeneric(
            corners, xy.reshape(-1, 1, 2), camera.matrix, None, flags=cv2.SOLVEPNP_IPPE
        )
    except cv2.error:
        return []
    found = [
        BoardPose(Similarity(cv2.Rodrigues(turns[i])[0], shifts[i].ravel()), float(errors[i].item()))
        for i in range(count)
    ]
    return [one for one in found if one.error < POOR and one.pose.shift[2] > 0]


@dataclass(frozen=True, eq=False)
class Relation:
    """Camera b against camera a: x_b = pose x_a; moments: that agree; shared: with the board in both."""

    pose: Similarity
    moments: int
    shared: int


def relate(a: Sequence[Sequence[BoardPose]], b: Sequence[Sequence[BoardPose]]) -> Relation | None:
    """The relative pose that most moments agree on; None without a moment.

    a, b: poses of the board in two cameras, moment by moment. Each of the two explanations of a flat board
    makes a proposal; the wrong ones of different moments do not agree with each other, the right ones do.
    """
    proposals, moment, distance = [], [], []
    step = max(1, -(-len(a) // MOST_MOMENTS))
    for number, (in_a, in_b) in enumerate(zip(a[::step], b[::step], strict=True)):
        for one in in_a:
            for other in in_b:
                proposals.append(other.pose.after(one.pose.inverse))
                moment.append(number)
                distance.append(np.linalg.norm(one.pose.shift))
    if not proposals:
        return None
    R = np.array([pose.rotation for pose in proposals])
    t = np.array([pose.shift for pose in proposals])
    cosine = (np.einsum("iab,jab->ij", R, R) - 1) / 2
    apart = np.linalg.norm(t[:, None] - t[None], axis=2) / np.array(distance)
    strain = np.arccos(np.clip(cosine, -1, 1)) / NEAR_ANGLE + apart / NEAR_SHIFT
    center = int(np.minimum(strain, 1).sum(axis=1).argmin())
    near = strain[center] < 1
    agreeing = len(set(np.array(moment)[near].tolist()))
    return Relation(
        Similarity(_mean_rotation(R[near]), np.median(t[near], axis=0)), agreeing, len(set(moment))
    )


def _mean_rotation(rotations: Array) -> Array:
    """The rotation with the least squared chordal distance to all: (N, 3, 3) -> (3, 3)."""
    U, _, Vt = np.linalg.svd(rotations.sum(axis=0))
    return np.asarray(U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt)
