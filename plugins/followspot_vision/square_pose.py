"""The pose of a square from its corners in one picture or several.

A flat square has two poses that explain one picture nearly as well (Schweighofer & Pinz 2006). Each view
proposes both of its own (IPPE, Collins & Bartoli 2014); all views judge them after each is refined over all
corners.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot.room import Camera

STEPS = 10
"""Gauss-Newton steps at most."""
CONVERGED = 1e-10
"""Square of a step that ends the refinement, rad^2 and m^2."""
DIFFERENT = 0.05
"""Angle between the faces of two poses that are not the same, rad."""
TINY = 1e-9
SIGNS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])


class Pose(NamedTuple):
    """A square in the room."""

    rotation: Array
    """(3, 3), from its axes to those of the room."""
    xyz: Array
    """(3,) m, its middle."""
    error: float
    """RMS distance of its corners from their images, px."""
    spread: Array
    """(3, 3) m^2/px^2, covariance of the middle for corners with a sigma of 1 px."""


def square(size: float) -> Array:
    """Corners of a square in its own axes, clockwise from the upper left one: (4, 3) m."""
    half = size / 2
    return np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])


def poses(cameras: list[Camera], xy: Array, size: float) -> list[Pose]:
    """The possible poses of a square of a size, m, the best first; none if its corners fit no square.

    xy: (V, 4, 2) px without distortion, in V > 0 cameras.
    """
    projection = np.array([camera.projection for camera in cameras])
    corners = square(size)
    proposed = [
        pose for camera, seen in zip(cameras, xy, strict=True) for pose in _proposed(camera, seen, size)
    ]
    refined = [_refined(projection, xy, corners, *pose) for pose in proposed]
    found: list[Pose] = []
    for pose in sorted((pose for pose in refined if pose is not None), key=lambda pose: pose.error):
        if all(pose.rotation[:, 2] @ other.rotation[:, 2] < np.cos(DIFFERENT) for other in found):
            found.append(pose)
    return found


def quaternion(rotation: Array) -> Array:
    """Unit quaternion w, x, y, z of a rotation (3, 3), with w >= 0: (4,)."""
    m = rotation
    turn = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    products = np.empty((4, 4))  # four times w w, w x, ..., z z
    products[1:, 1:] = m + m.T
    products[0, 1:] = products[1:, 0] = turn
    np.fill_diagonal(products, 1 + SIGNS @ np.diag(m))
    found = products[products.diagonal().argmax()]  # by its largest number, the others are divided exactly
    found = found / np.sqrt(found @ found)
    return np.asarray(-found if found[0] < 0 else found)


def _proposed(camera: Camera, xy: Array, size: float) -> list[tuple[Array, Array]]:
    """Both poses that one view proposes, in the room."""
    if not np.isfinite(xy).all():
        return []
    try:
        count, turns, places, _ = cv2.solvePnPGeneric(
            square(size), xy, camera.matrix, np.zeros(5), flags=cv2.SOLVEPNP_IPPE_SQUARE
        )
    except cv2.error:
        return []
    back = camera.rotation.T
    local = [(cv2.Rodrigues(turns[k])[0], places[k].reshape(3)) for k in range(count)]
    return [
        (back @ rotation, back @ (place - camera.translation))
        for rotation, place in local
        if np.isfinite(rotation).all() and place[2] > 0
    ]


def _refined(projection: Array, xy: Array, corners: Array, rotation: Array, xyz: Array) -> Pose | None:
    """The nearest pose of least squared error over all corners; None if they leave the pictures' front."""
    for _ in range(STEPS):
        seen = _linearised(projection, corners @ rotation.T, xyz)
        if seen is None:
            return None
        image, slope = seen
        design, residual = slope.reshape(-1, 6), (xy - image).reshape(-1)
        step = np.linalg.lstsq(design, residual, rcond=None)[0]
        rotation = cv2.Rodrigues(step[:3])[0] @ rotation
        xyz = xyz + step[3:]
        if step @ step < CONVERGED:
            break
    seen = _linearised(projection, corners @ rotation.T, xyz)
    if seen is None:
        return None
    image, slope = seen
    error = float(np.sqrt(np.mean(np.square(xy - image).sum(axis=2))))
    design = slope.reshape(-1, 6)
    spread = np.linalg.pinv(design.T @ design)[3:, 3:]
    return Pose(rotation, xyz, error, spread) if np.isfinite(error) else None


def _linearised(projection: Array, arms: Array, xyz: Array) -> tuple[Array, Array] | None:
    """Images of the corners, (V, 4, 2) px, and their derivatives by turn and place, (V, 4, 2, 6).

    arms: (4, 3) m, corners from the middle, in the room. None if a corner is behind a camera.
    """
    points = arms + xyz
    image = points @ projection[:, :, :3].swapaxes(1, 2) + projection[:, None, :, 3]
    depth = image[..., 2:]
    if not (depth > TINY).all():
        return None
    pixel = image[..., :2] / depth
    by_place = (projection[:, None, :2, :3] - pixel[..., None] * projection[:, None, 2:, :3]) / depth[
        ..., None
    ]
    by_turn = np.cross(arms[:, None], by_place)  # d(w x a) = w . (a x d)
    return pixel, np.concatenate([by_turn, by_place], axis=-1)
