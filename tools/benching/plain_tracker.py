"""The six-camera ball tracker as a careful engineer writes it in a day: the yardstick of benchmarks.

It does what the default graph does for balls in view: blobs by colour or brightness, near the prediction or
in whole images; disc centres by votes of edges; epipolar and homography tests of pairs; triangulation; mean
shift; constant-velocity prediction. OpenCV touches pixels, and only those of search windows while a ball is
tracked; everything else is numpy, over all targets, pairs or votes at once. What it leaves out: covariances,
evidence of existence and identity, sizes, bridges over gaps, cameras out of step, files. No graph, no
messages, no plugins.

    for positions in run(room, frames): ...   # frames: {camera: [picture, ...]}
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np

from benching.plain_blobs import Blob, View, blobs, centers
from followspot.geometry import fundamental_matrix, plane_homography
from followspot.messages import Array
from followspot.room import Camera, Room

PERIOD = 1 / 30
SEARCH_PX, SEARCH_M, MISSING_FRAMES = 10.0, 0.225, 25
EPIPOLAR_PX, PLANE_PX = 3.0, 3.0
BANDWIDTH_M, RESTS_M = 0.04, 0.0005


class Spots(NamedTuple):
    """Blobs of all targets in all cameras. view: numbers of cameras, (N,); xy: undistorted, (N, 2) px."""

    view: Array
    target: Array
    xy: Array


class Balls:
    """The state of all targets, place NaN if lost."""

    def __init__(self, count: int) -> None:
        self.place = np.full((count, 3), np.nan)
        self.velocity = np.zeros((count, 3))
        self.unseen = np.zeros(count, int)

    @property
    def known(self) -> Array:
        return np.asarray(~np.isnan(self.place[:, 0]))

    @property
    def predicted(self) -> Array:
        return self.place + self.velocity * PERIOD

    def follow(self, measured: Array) -> None:
        """Constant velocity with fixed gains; a ball that is missing for too long is lost."""
        seen, known = ~np.isnan(measured[:, 0]), self.known
        new, old, gone = seen & ~known, seen & known, ~seen
        residual = measured - self.predicted
        self.place[old] = self.predicted[old] + 0.8 * residual[old]
        self.velocity[old] += 0.5 * residual[old] / PERIOD
        self.place[new], self.velocity[new | gone] = measured[new], 0
        self.unseen[seen] = 0
        self.unseen[gone] += 1
        self.place[self.unseen > MISSING_FRAMES] = np.nan


class Projection:
    """All cameras as arrays: images of points in all of them at once."""

    def __init__(self, cameras: Sequence[Camera]) -> None:
        self.R = np.array([camera.rotation for camera in cameras])
        self.t = np.array([camera.translation for camera in cameras])
        self.K = np.array([camera.matrix for camera in cameras])
        self.lens = np.array([camera.distortion for camera in cameras])[:, None].transpose(2, 0, 1)

    def image(self, points: Array) -> Array:
        """(T, 3) or (C, T, 3) m -> (C, T, 2) px."""
        local = points @ self.R.transpose(0, 2, 1) + self.t[:, None]
        x, y = local[..., 0] / local[..., 2], local[..., 1] / local[..., 2]
        k1, k2, p1, p2, k3 = self.lens
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        K = self.K[:, None]
        return np.stack([u * K[..., 0, 0] + K[..., 0, 2], v * K[..., 1, 1] + K[..., 1, 2]], axis=-1)


def run(
    room: Room, frames: Mapping[str, Sequence[Array]], *, searching: bool = False
) -> Iterator[dict[str, Array]]:
    """Track all targets of the room: frame by frame the positions, m, of those that were measured.

    searching: no position is believed, so that all targets are sought in whole images in every frame.
    """
    cameras = list(room.cameras.values())
    views = [View(room, camera, number) for number, camera in enumerate(cameras)]
    projection, pairs = Projection(cameras), Pairs(room, cameras)
    radius = np.array([target.radius for target in room.targets.values()])
    balls = Balls(len(room.targets))
    for number in range(min(map(len, frames.values()))):
        pictures = [frames[camera.name][number] for camera in cameras]
        spots = found(views, pictures, projection, radius, balls)
        measured = fused(*pairs.candidates(spots, balls), balls)
        if not searching:
            balls.follow(measured)
        yield {
            name: balls.place[i]
            for i, name in enumerate(room.targets)
            if not np.isnan(measured[i, 0] + balls.place[i, 0])
        }


def found(
    views: Sequence[View], pictures: Sequence[Array], projection: Projection, radius: Array, balls: Balls
) -> Spots:
    """Blobs of all targets: near their predictions, or anywhere while they are lost."""
    center, now = projection.image(balls.predicted), projection.image(balls.place)
    side = projection.image(balls.place + projection.R[:, 0, None] * radius[:, None])
    outline = np.linalg.norm(side - now, axis=2)
    reach = np.maximum(SEARCH_PX, 1.5 * np.linalg.norm(center - now, axis=2))
    known = balls.known
    seen: list[Blob] = []
    for view, picture in zip(views, pictures, strict=True):
        for target in map(int, np.flatnonzero(known)):
            half = int(reach[view.number, target]) + 10
            x, y = map(int, center[view.number, target])
            left, top = max(x - half, 0), max(y - half, 0)
            crop = picture[top : max(y + half, 0), left : max(x + half, 0)]
            if crop.size:
                seen += blobs(view, target, view.prepared(crop), (left, top), outline[view.number, target])
        if not known.all():
            whole = view.prepared(picture)
            for rect, wanted in view.regions(whole):
                part = whole[rect.top : rect.bottom, rect.left : rect.right]
                for target in map(int, np.flatnonzero(wanted & ~known)):
                    seen += blobs(view, target, part, (rect.left, rect.top), None)
    if not seen:
        return Spots(np.empty(0, int), np.empty(0, int), np.empty((0, 2)))
    seen_by, target = np.array([(blob.view, blob.target) for blob in seen]).T
    pixel = centers(seen)
    off = np.linalg.norm(pixel - center[seen_by, target], axis=1)
    near = ~known[target] | (off <= reach[seen_by, target])
    seen_by, target, pixel = seen_by[near], target[near], pixel[near]
    for view in views:
        own = seen_by == view.number
        if own.any():
            K = view.camera.matrix
            pixel[own] = cv2.undistortPoints(pixel[own, None], K, view.camera.distortion, P=K)[:, 0]
    return Spots(seen_by, target, pixel)


class Pairs:
    """All pairs of cameras: tests and triangulation of pairs of blobs."""

    def __init__(self, room: Room, cameras: Sequence[Camera]) -> None:
        count = len(cameras)
        self.F = np.zeros((count, count, 3, 3))
        self.H = np.zeros((count, count, len(room.planes), 3, 3))
        for (i, a), (j, b) in combinations(enumerate(cameras), 2):
            self.F[i, j] = fundamental_matrix(a.projection, b.projection)
            self.H[i, j] = [plane_homography(a, b, plane) for plane in room.planes.values()]
        self.P = np.array([camera.projection for camera in cameras])
        self.color = np.array([camera.kind == "color" for camera in cameras])

    def candidates(self, spots: Spots, balls: Balls) -> tuple[Array, Array, Array]:
        """Points, weights and targets of all pairs of blobs that pass the tests: (N, 3) m, (N,), (N,)."""
        view, target, xy = spots
        first, second = np.nonzero((target[:, None] == target) & (view[:, None] < view))
        alike = self.color[view[first]] == self.color[view[second]]
        kept = balls.known[target[first]] | ~alike
        first, second = first[kept], second[kept]
        a, b, whose = view[first], view[second], target[first]
        one, other = (np.column_stack([xy[n], np.ones(len(n))]) for n in (first, second))
        F = self.F[a, b]
        line2, line1 = (F @ one[..., None])[..., 0], (other[:, None] @ F)[:, 0]
        algebraic = np.abs((other * line2).sum(axis=1))
        distance = algebraic / np.minimum(np.hypot(*line1.T[:2]), np.hypot(*line2.T[:2]))
        moved = (self.H[a, b] @ one[:, None, :, None])[..., 0]
        off = np.linalg.norm(moved[..., :2] / moved[..., 2:] - other[:, None, :2], axis=2)
        projected = (off < PLANE_PX).any(axis=1) & self.color[a] & self.color[b]
        kept = (distance < EPIPOLAR_PX) & ~projected
        points = self.triangulated(a[kept], b[kept], one[kept], other[kept])
        whose, distance = whose[kept], distance[kept]
        speed = np.linalg.norm(balls.velocity[whose], axis=1)
        far = np.linalg.norm(points - balls.predicted[whose], axis=1) > np.maximum(
            SEARCH_M, 2 * speed * PERIOD
        )
        return points[~far], np.exp(-(distance[~far] ** 2) / 2), whose[~far]

    def triangulated(self, a: Array, b: Array, one: Array, other: Array) -> Array:
        """Points by the linear inhomogeneous method (Hartley & Zisserman 12.2), (N, 3) m."""
        rows = [
            x[:, axis, None] * self.P[c, 2] - self.P[c, axis]
            for c, x in ((a, one), (b, other))
            for axis in (0, 1)
        ]
        A = np.stack(rows, axis=1)
        A /= np.linalg.norm(A, axis=2, keepdims=True)
        left = A[..., :3].transpose(0, 2, 1)
        return np.asarray(np.linalg.solve(left @ A[..., :3], -left @ A[..., 3:])[..., 0])


def fused(points: Array, weights: Array, whose: Array, balls: Balls) -> Array:
    """Mean shift for each target, from the prediction or a lost one's heaviest point; NaN without points."""
    measured = np.full_like(balls.place, np.nan)
    predicted, known = balls.predicted, balls.known
    for target in np.unique(whose):
        own = whose == target
        sample, weight = points[own], weights[own]
        center = predicted[target] if known[target] else sample[weight.argmax()]
        for _ in range(30):
            off = sample - center
            inside = (off * off).sum(axis=1) < BANDWIDTH_M**2
            chosen = weight * inside if inside.any() else weight
            mean = chosen @ sample / chosen.sum()
            rests = np.abs(mean - center).max() < RESTS_M
            center = mean
            if rests:
                break
        measured[target] = center
    return measured
