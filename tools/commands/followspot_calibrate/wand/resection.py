"""Pose of one camera: relative to another one, or among known points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.geometry import undistort
from followspot.messages import Array

WIDE_ENOUGH = np.radians(30)
"""Angle between two rays above which a wider baseline makes a point no more certain."""
FEWEST = 8
"""Points that a camera must agree with to be placed; three of them are enough for a guess."""
SHARE = 0.01
"""Largest error of a point that agrees, over the longer side of the picture."""
TRIALS = 500


@dataclass(frozen=True, eq=False)
class Relation:
    """Pose of a second camera in the frame of a first, the baseline of unit length.

    worth: points that agree, times the sine of their median angle between the rays, at most 30 degrees.
    """

    rotation: Array
    translation: Array
    worth: float


def relate(first: Camera, second: Camera, pixel: Array) -> Relation | None:
    """Relative pose from the essential matrix (H&Z, section 9.6) of shared points, (M, 2, 2) px.

    None if too few points agree with any.
    """
    import cv2

    xy1, xy2 = normalised(first, pixel[:, 0]), normalised(second, pixel[:, 1])
    limit = SHARE * max(first.size) / min(first.matrix[0, 0], second.matrix[0, 0])
    E, inlier = cv2.findEssentialMat(xy1, xy2, np.eye(3), cv2.USAC_MAGSAC, 0.9999, limit / 2, TRIALS)
    if E is None or E.shape != (3, 3) or inlier.sum() < FEWEST:
        return None
    count, rotation, shift, agree = cv2.recoverPose(E, xy1, xy2, np.eye(3), mask=inlier)
    if count < FEWEST:
        return None
    good = np.asarray(agree)[:, 0] > 0
    rays = np.stack([_rays(xy1[good]), _rays(xy2[good]) @ rotation], axis=1)
    cosine = np.einsum("nk,nk->n", rays[:, 0], rays[:, 1])
    angle = min(float(np.median(np.arccos(np.clip(cosine, -1, 1)))), WIDE_ENOUGH)
    return Relation(np.asarray(rotation), np.asarray(shift)[:, 0], count * np.sin(angle))


def resect(camera: Camera, points: Array, pixel: Array) -> tuple[Camera, int] | None:
    """The camera with the pose that explains its sightings of known points, and the number that agree (P3P).

    points: (M, 3) m; pixel: (M, 2) px. None if too few agree.
    """
    import cv2

    if len(points) < FEWEST:
        return None
    limit = SHARE * max(camera.size) / camera.matrix[0, 0]
    xy = normalised(camera, pixel)
    found, turn, shift, agree = cv2.solvePnPRansac(
        points, xy, np.eye(3), None, iterationsCount=TRIALS, reprojectionError=limit, flags=cv2.SOLVEPNP_AP3P
    )
    if not found or agree is None or len(agree) < FEWEST:
        return None
    agree = agree[:, 0]
    turn, shift = cv2.solvePnPRefineLM(points[agree], xy[agree], np.eye(3), None, turn, shift)
    rotation = cv2.Rodrigues(turn)[0]
    return replace(camera, rotation=rotation, translation=shift[:, 0]), len(agree)


def normalised(camera: Camera, pixel: Array) -> Array:
    """K^-1 of the undistorted pixels: (M, 2) px -> (M, 2)."""
    K = camera.matrix
    return np.asarray((undistort(camera, pixel) - K[:2, 2]) / np.diagonal(K)[:2])


def _rays(xy: Array) -> Array:
    directions = np.column_stack([xy, np.ones(len(xy))])
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))
