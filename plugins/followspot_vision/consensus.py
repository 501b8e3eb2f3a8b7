"""Consensus of points of several cameras on points of the room; each point is used once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from followspot.geometry import triangulate_pairs
from followspot.messages import Array

STEPS = 5
"""Gauss-Newton steps; after the linear start two are enough."""
MINIMUM_EIGENVALUE_RATIO = 1e-9
"""Smallest ratio of the least to the largest eigenvalue of the normal matrix of a determined point."""


@dataclass(frozen=True)
class ViewPoints:
    """N points of one label in the pictures. camera: (N,) numbers; xy: (N, 2) px undistorted; projection:
    (N, 3, 4) and center: (N, 3) m of their cameras; ray: (N, 3) unit vectors.
    """

    camera: Array
    xy: Array
    projection: Array
    center: Array
    ray: Array

    def rows(self, keep: Array) -> ViewPoints:
        """Only these rows."""
        return ViewPoints(*(each[keep] for each in self.__dict__.values()))


@dataclass(frozen=True)
class ConsensusPoint:
    """xyz: (3,) m; normal: (3, 3) 1/m^2 for an error of 1 px; rows: of its points; error: RMS px."""

    xyz: Array
    normal: Array
    rows: Array
    error: float


def consensus_points(points: ViewPoints, gate: float, views: int) -> Iterator[ConsensusPoint]:
    """Points of the room that `views` cameras or more agree on within `gate`, px; each point is used once.

    A hypothesis is the point between the rays of two points. It counts as many cameras as have a point
    within the gate of its image, nearest first; the one with most cameras, then least error, wins.
    """
    left = np.arange(len(points.xy))
    while len(left) >= views:
        rows = _best_hypothesis(points.rows(left), gate, views)
        if rows is None:
            return
        found = _refined(points, left[rows[1]], rows[0])
        left = np.delete(left, rows[1])
        if found is not None:
            yield found


def _best_hypothesis(points: ViewPoints, gate: float, views: int) -> tuple[Array, Array] | None:
    """The best hypothesis, (3,) m, and the rows that agree with it; None if too few do."""
    ends = np.stack(np.triu_indices(len(points.xy), 1), axis=1)
    ends = ends[points.camera[ends[:, 0]] != points.camera[ends[:, 1]]]
    xyz = triangulate_pairs(points.center[ends], points.ray[ends])
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    error = _errors(points, xyz)
    cameras = np.unique(points.camera)
    nearest = np.empty((len(xyz), len(cameras)), int)
    for column, camera in enumerate(cameras):
        rows = np.flatnonzero(points.camera == camera)
        nearest[:, column] = rows[error[:, rows].argmin(axis=1)]
    least = np.take_along_axis(error, nearest, axis=1)
    agrees = least <= gate
    count = agrees.sum(axis=1)
    if not len(xyz) or count.max() < views:
        return None
    cost = np.minimum(least, gate).sum(axis=1)
    best = np.lexsort([cost, -count])[0]
    return xyz[best], nearest[best, agrees[best]]


def _errors(points: ViewPoints, xyz: Array) -> Array:
    """Reprojection errors of (P, 3) m at the points, (P, N) px; infinite behind a camera."""
    image = np.einsum("nij,pj->pni", points.projection[:, :, :3], xyz) + points.projection[:, :, 3]
    front = image[..., 2] > 0
    depth = np.where(front, image[..., 2], 1.0)
    apart = np.linalg.norm(image[..., :2] / depth[..., None] - points.xy, axis=2)
    return np.asarray(np.where(front, apart, np.inf))


def _refined(points: ViewPoints, rows: Array, start: Array) -> ConsensusPoint | None:
    """The point with least squared error in the pictures; None if the points do not determine one."""
    P, xy = points.projection[rows], points.xy[rows]
    xyz = start
    for _ in range(STEPS):
        image = P[:, :, :3] @ xyz + P[:, :, 3]
        if (image[:, 2] <= 0).any():
            return None
        there = image[:, :2] / image[:, 2:]
        J = (P[:, :2, :3] - there[..., None] * P[:, 2:, :3]) / image[:, 2:, None]
        normal = np.einsum("nij,nik->jk", J, J)
        values = np.linalg.eigvalsh(normal)
        if not values[0] > MINIMUM_EIGENVALUE_RATIO * values[-1]:
            return None
        xyz = xyz + np.linalg.solve(normal, np.einsum("nij,ni->j", J, xy - there))
    error = _errors(points.rows(rows), xyz[None])[0]
    return ConsensusPoint(xyz, normal, rows, float(np.sqrt(np.square(error).mean())))
