"""The people of a room as messages."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from followspot import Array
from followspot.people import Poses, Skeletons
from followspot.tracking import PREDICTED, TRACKED
from followspot_persons.associate.boxes.ellipsoid import HEIGHT, PLACE, SPEED
from followspot_persons.associate.boxes.shape_mixture import ShapeMixture
from followspot_persons.associate.joints.skeleton_pose import UNKNOWN, poses_of
from followspot_persons.associate.joints.tracks import JointTracks
from followspot_persons.associate.tracks.tracks import Tracks

WALKING = 0.3
"""Speed from which the way of a person tells where the chest points, m/s."""


def joint_poses(tracks: Tracks[JointTracks], joints: tuple[str, ...], maximum_sigma: float) -> Poses:
    """The confirmed people; joints that are less certain than `maximum_sigma`, m, tell nothing."""
    rows = _reported(tracks)
    bodies = tracks.bodies.where(rows)
    sigma, sure = _certainty(bodies, maximum_sigma)
    none = ~sure.any(axis=1)
    sure[none] = bodies.known[none]
    found = poses_of(joints, np.where(sure[..., None], bodies.xyz, np.nan), sigma)
    return _poses(tracks, rows, found.pose, found.sigma, np.asarray(bodies.views.any(axis=1)))


def skeletons_of(tracks: Tracks[JointTracks], joints: tuple[str, ...], maximum_sigma: float) -> Skeletons:
    """Joints of the confirmed people that are certain enough."""
    rows = _reported(tracks)
    bodies = tracks.bodies.where(rows)
    _, sure = _certainty(bodies, maximum_sigma)
    person, label = np.nonzero(sure)
    return Skeletons(
        labels=joints,
        person=tracks.life.number[rows][person].astype(np.int32),
        label=label.astype(np.int32),
        xyz=bodies.xyz[person, label],
        covariance=bodies.position_covariance[person, label],
        views=bodies.views[person, label].astype(np.int32),
    )


def box_poses(tracks: Tracks[ShapeMixture], before: Mapping[int, float]) -> tuple[Poses, dict[int, float]]:
    """The confirmed people, and the heading of each number, rad.

    Boxes do not tell where a chest points: it is the way of a walking person, and stays while the person
    stands. before: headings so far.
    """
    rows = _reported(tracks)
    bodies, number = tracks.bodies.where(rows).mean, tracks.life.number[rows]
    state, variance = bodies.state, np.diagonal(bodies.covariance, axis1=1, axis2=2)
    way, pace = state[:, SPEED], np.hypot(*state[:, SPEED][:, :2].T)
    last = np.array([before.get(int(one), np.nan) for one in number])
    heading = np.where(pace > WALKING, np.arctan2(way[:, 1], way[:, 0]), last)
    sigma_way = np.where(
        pace > WALKING, np.sqrt(variance[:, SPEED][:, :2].mean(axis=1)) / pace.clip(1e-3), UNKNOWN
    )
    height = np.exp(state[:, HEIGHT])
    zero, unknown = np.zeros(len(rows)), np.full(len(rows), UNKNOWN)
    pose = np.column_stack([state[:, :2], state[:, 2] + height, np.nan_to_num(heading), zero, zero])
    top = np.sqrt(variance[:, 2] + height**2 * variance[:, HEIGHT])
    sigma = np.column_stack(
        [np.sqrt(variance[:, PLACE][:, :2]), top, np.minimum(sigma_way, UNKNOWN), unknown, unknown]
    )
    known = {int(one): float(angle) for one, angle in zip(number, heading, strict=True) if np.isfinite(angle)}
    return _poses(tracks, rows, pose, sigma, bodies.views > 0), known


def _reported(tracks: Tracks[JointTracks] | Tracks[ShapeMixture]) -> Array:
    """Rows of the confirmed people by number."""
    rows = np.flatnonzero(tracks.life.number > 0)
    return rows[np.argsort(tracks.life.number[rows], kind="stable")]


def _certainty(bodies: JointTracks, maximum_sigma: float) -> tuple[Array, Array]:
    """Largest sigma of each joint, (M, J) m, and whether it is certain enough."""
    if not bodies.position_covariance.size:
        none = np.zeros(bodies.known.shape)
        return none, none.astype(bool)
    sigma = np.sqrt(np.maximum(np.linalg.eigvalsh(bodies.position_covariance)[..., -1], 0.0))
    return sigma, bodies.known & (sigma <= maximum_sigma)


def _poses(
    tracks: Tracks[JointTracks] | Tracks[ShapeMixture], rows: Array, pose: Array, sigma: Array, seen: Array
) -> Poses:
    return Poses(
        camera="",
        person=tracks.life.number[rows].astype(np.int32),
        state=np.where(seen, TRACKED, PREDICTED).astype(np.uint8),
        xy=pose[:, :2].copy(),
        height=pose[:, 2].copy(),
        heading=pose[:, 3].copy(),
        pan=pose[:, 4].copy(),
        tilt=pose[:, 5].copy(),
        sigma=sigma,
        confidence=1 / (1 + np.exp(-tracks.life.odds[rows])),
    )
