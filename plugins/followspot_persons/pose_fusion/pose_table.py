"""The poses of several cameras in one table, and the fusion of those of one person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.geometry import wrap
from followspot.people import Poses
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT, X, Y

MAXIMUM_DEVIATION = np.radians(70)
"""Headings within this angle of the best one are averaged; others are outliers."""
PRIOR_CONFIDENCE = 0.15
"""Confidence of the heading that the person had before, in the vote."""
NETWORK_SIGMA = 0.03
"""Sigma that adds to that of poses of the room, m: the joints of a network lie beside those of the body."""
MIN_SIGMA = np.array([0.01, 0.01, 0.01, 0.1, 0.1, 0.05])
"""Smallest sigma of a camera's pose: m, m, m, rad, rad, rad."""


@dataclass(frozen=True, eq=False)
class PoseTable:
    """K poses of all cameras. camera: (K,) number in the room, -1 for poses of the room; names: of the
    cameras, one for each row; person: (K,) number there; pose, sigma: (K, 6); information: (K, 2, 2) 1/m^2
    of the position; covariance: its inverse; confidence: (K,); eye: (K, 3) m, camera centre, NaN for poses of
    the room.
    """

    camera: Array
    names: tuple[str, ...]
    person: Array
    pose: Array
    sigma: Array
    information: Array
    covariance: Array
    confidence: Array
    eye: Array


def pose_table(
    poses: Sequence[Poses], cameras: Mapping[str, Camera], direction: float, distance: float
) -> PoseTable:
    """Poses of all cameras, each position as uncertain as a camera is: little across its view, much along it.

    Poses without a camera are of the room, with their own sigma. direction: one sigma, rad; distance: one
    sigma, of the distance.
    """
    order = {name: number for number, name in enumerate(cameras)}
    pose, sigma = np.concatenate([_states(p) for p in poses]), np.concatenate([p.sigma for p in poses])
    center = {name: camera.center for name, camera in cameras.items()} | {"": np.full(3, np.nan)}
    eye = np.concatenate([np.tile(center[p.camera], (len(p.person), 1)) for p in poses])
    along = pose[:, :2] - eye[:, :2]
    own = np.square(sigma[:, :2]) + NETWORK_SIGMA**2
    of_room = np.isnan(eye[:, :1, None])
    return PoseTable(
        camera=np.concatenate([np.full(len(p.person), order.get(p.camera, -1)) for p in poses]),
        names=tuple(p.camera for p in poses for _ in p.person),
        person=np.concatenate([p.person for p in poses]),
        pose=pose,
        sigma=sigma,
        information=np.where(of_room, _diagonal(1 / own), information(along, direction, distance)),
        covariance=np.where(of_room, _diagonal(own), information(along, direction, distance, power=1)),
        confidence=np.concatenate([p.confidence for p in poses]),
        eye=eye,
    )


def _diagonal(values: Array) -> Array:
    """Matrices (K, 2, 2) with these diagonals (K, 2)."""
    return np.asarray(values[:, :, None] * np.eye(2))


def _states(poses: Poses) -> Array:
    return np.column_stack([poses.xy, poses.height, poses.heading, poses.pan, poses.tilt])


def information(offset: Array, direction: float, distance: float, power: int = -1) -> Array:
    """Inverse covariance of positions seen from a camera: (K, 2) m from it -> (K, 2, 2) 1/m^2.

    direction: one sigma, rad; distance: one sigma, of the distance; power: 1 for the covariance itself, m^2.
    """
    length = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 0.1)
    along = offset / length[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    weights = (np.array([distance, direction])[:, None] * length) ** (2 * power)
    return np.asarray(
        weights[0, :, None, None] * along[:, :, None] * along[:, None, :]
        + weights[1, :, None, None] * across[:, :, None] * across[:, None, :]
    )


def fused_pose(table: PoseTable, rows: list[int], before: Array | None) -> tuple[Array, Array, Array]:
    """Pose and sigma, (6,) each, of one person from these rows, and its position's covariance (2, 2) m^2.

    Positions are weighted by their information, pans and tilts by their variances. Headings are voted on.
    Heights are those of the lines of sight to the head's top at the position. before: the last pose (6,), if
    there is one.
    """
    trust = table.confidence[rows] + 1e-3
    weight = trust[:, None] / np.maximum(table.sigma[rows], MIN_SIGMA) ** 2
    pose = (weight * table.pose[rows]).sum(axis=0) / weight.sum(axis=0)
    sigma = 1 / np.sqrt((weight / trust[:, None]).sum(axis=0))
    precision = (trust[:, None, None] * table.information[rows]).sum(axis=0)
    moment = (trust[:, None] * np.einsum("kij,kj->ki", table.information[rows], table.pose[rows, :2])).sum(
        axis=0
    )
    covariance = np.diag(sigma[[X, Y]] ** 2)
    with suppress(np.linalg.LinAlgError):  # without information on the position the mean remains
        pose[[X, Y]] = np.linalg.solve(precision, moment)
        covariance = np.linalg.inv(table.information[rows].sum(axis=0))
        sigma[[X, Y]] = np.sqrt(np.diag(covariance))
    pose[HEADING], agreeing = _heading(table.pose[rows, HEADING], weight[:, HEADING], before)
    for column in (PAN, TILT):
        own = weight[:, column] * (agreeing if column == PAN else 1.0)
        pose[column] = own @ table.pose[rows, column] / own.sum()
    pose[HEIGHT] = trust @ _line_of_sight_height(table.eye[rows], table.pose[rows], pose[:2]) / trust.sum()
    return pose, sigma, covariance


def _line_of_sight_height(eye: Array, pose: Array, position: Array) -> Array:
    """Heights at a position (2,) m of the lines of sight to the tops of heads, (K,) m.

    eye: (K, 3) m; pose: (K, 6). One camera determines the direction of the head's top, hardly its distance;
    several determine the position, and with it the height. Poses of the room, without an eye, keep theirs.
    """
    reported = np.maximum(np.hypot(*(pose[:, :2] - eye[:, :2]).T), 0.1)
    true = np.hypot(*(position - eye[:, :2]).T)
    height = eye[:, 2] + (pose[:, HEIGHT] - eye[:, 2]) * true / reported
    return np.asarray(np.where(np.isnan(eye[:, 2]), pose[:, HEIGHT], height))


def _heading(heading: Array, weight: Array, before: Array | None) -> tuple[float, Array]:
    """The heading that most of the weight agrees on, and which rows agree with it (K,)."""
    candidates, support = heading, weight / weight.sum()
    if before is not None:
        candidates = np.append(heading, before[HEADING])
        support = np.append(support, PRIOR_CONFIDENCE)
    near = np.exp(4 * (np.cos(candidates[:, None] - candidates) - 1))
    best = heading[(near @ support)[: len(heading)].argmax()]
    difference = wrap(heading - best)
    agreeing = np.abs(difference) < MAXIMUM_DEVIATION
    share = weight * agreeing
    return float(wrap(best + share @ difference / share.sum())), agreeing.astype(float)
