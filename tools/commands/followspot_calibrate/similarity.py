"""Similarity transforms between frames of reference (Umeyama 1991)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from followspot import Camera
from followspot.messages import Array

NEAR = 0.02
"""Error that still agrees, over the root mean square distance of the points from their middle."""
FLAT = 1e-3
"""Second singular value over the first below which points lie on a line."""


@dataclass(frozen=True, eq=False)
class Similarity:
    """X_new = scale rotation X_old + shift; rotation (3, 3), shift (3,) m.

    The pose of a camera is one, from the room to the camera.
    """

    rotation: Array
    shift: Array
    scale: float = 1.0

    def points(self, points: Array) -> Array:
        """Points in the new frame, (N, 3)."""
        return np.asarray(self.scale * points @ self.rotation.T + self.shift)

    def after(self, first: Similarity) -> Similarity:
        """The similarity that leads through the first one and then this one."""
        return Similarity(self.rotation @ first.rotation, self.points(first.shift), self.scale * first.scale)

    @property
    def inverse(self) -> Similarity:
        """The way back."""
        return Similarity(self.rotation.T, -self.rotation.T @ self.shift / self.scale, 1 / self.scale)

    def camera(self, camera: Camera) -> Camera:
        """The camera in the new frame; it sees the same."""
        rotation = camera.rotation @ self.rotation.T
        translation = self.scale * camera.translation - rotation @ self.shift
        return replace(camera, rotation=rotation, translation=translation)


def similarity(source: Array, target: Array, *, scaled: bool = True) -> Similarity:
    """The similarity that takes points nearest to others in the sense of least squares; (N, 3) each.

    scaled: whether the scale may differ. Raises ValueError for fewer than three points or points on a line.
    """
    if on_a_line(source) or on_a_line(target):
        raise ValueError("a frame of reference needs three points that are not on a line")
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    U, strength, Vt = np.linalg.svd(b.T @ a)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    rotation = (U * sign) @ Vt
    scale = float(strength @ sign / np.square(a).sum()) if scaled else 1.0
    return Similarity(rotation, target.mean(axis=0) - scale * rotation @ source.mean(axis=0), scale)


def agreeing(source: Array, target: Array, *, scaled: bool = True) -> Array:
    """Points that agree on one similarity, (N,) bool: those near the one with the least median error.

    Each triple of points proposes one. All agree if there are only three.
    """
    limit = NEAR * spread(target)
    best, agree = np.inf, np.ones(len(source), bool)
    for three in map(list, combinations(range(len(source)), 3) if len(source) > 3 else ()):
        if on_a_line(source[three]) or on_a_line(target[three]):
            continue
        proposal = similarity(source[three], target[three], scaled=scaled)
        error = np.linalg.norm(proposal.points(source) - target, axis=1)
        if np.median(error) < best:
            best, agree = float(np.median(error)), error < limit
    return agree if agree.sum() >= 3 else np.ones(len(source), bool)


def spread(points: Array | Sequence[Array]) -> float:
    """Root mean square distance of points from their middle, m."""
    points = np.asarray(points)
    return float(np.sqrt(np.square(points - points.mean(axis=0)).sum(axis=1).mean()))


def on_a_line(points: Array) -> bool:
    """True if points, (N, 3), lie on a line, so that a rotation about it stays open."""
    if len(points) < 3:
        return True
    strength = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(strength[1] <= FLAT * strength[0])
