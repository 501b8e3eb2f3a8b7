"""The six-camera ball tracker as one plain OpenCV script: the yardstick that benchmarks compare with.

It does the work of the stages in `followspot_balls` the straightforward way: loops over cameras, targets
and pairs around cv2 and numpy calls, undistorted centroids, epipolar and homography tests, one
triangulation per pair, mean shift, constant-velocity prediction. No graph, no messages, no plugins.

    for positions in run(room, frames): ...   # frames: {camera: [picture, ...]}
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import cv2
import numpy as np

from followspot.geometry import fundamental_matrix, plane_homography
from followspot.messages import Array
from followspot.room import Camera, Room

PERIOD = 1 / 30
SEARCH_PX, SEARCH_M, MISSING_FRAMES = 10.0, 0.225, 25
EPIPOLAR_PX, PLANE_PX, SIMILARITY = 3.0, 3.0, 0.8
BANDWIDTH_M, RESTS_M = 0.04, 0.0005
COLOR_EDGE, INFRARED_EDGE = 0.7, 0.45


@dataclass
class Ball:
    """The state of one target."""

    place: Array | None = None
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    unseen: int = 0


@dataclass
class Spot:
    """A blob in one camera: picture and undistorted position."""

    pixel: Array
    xy: Array


def run(
    room: Room, frames: Mapping[str, Sequence[Array]], *, searching: bool = False
) -> Iterator[dict[str, Array]]:
    """Track all targets of the room: frame by frame the positions, m, of those that were measured.

    searching: no position is believed, so that all targets are sought in whole images in every frame.
    """
    pairs = list(combinations(room.cameras.values(), 2))
    F = {(a.name, b.name): fundamental_matrix(a.projection, b.projection) for a, b in pairs}
    H = {(a.name, b.name): [plane_homography(a, b, p) for p in room.planes.values()] for a, b in pairs}
    balls = {name: Ball() for name in room.targets}
    for number in range(min(map(len, frames.values()))):
        pictures = {name: prepare(camera, frames[name][number]) for name, camera in room.cameras.items()}
        spots = {
            (camera.name, target): find_spots(room, camera, target, pictures[camera.name], ball)
            for camera in room.cameras.values()
            for target, ball in balls.items()
        }
        seen: dict[str, Array] = {}
        for target, ball in balls.items():
            points, weights = candidates(room, target, spots, pairs, F, H, ball)
            position = fuse(points, weights, ball)
            if not searching:
                follow(ball, position)
            if position is not None and ball.place is not None:
                seen[target] = ball.place
        yield seen


def prepare(camera: Camera, picture: Array) -> Array:
    """HSV of a colour picture, grey level of an infrared one."""
    if camera.kind == "color":
        return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL))
    return picture if picture.ndim == 2 else np.ascontiguousarray(picture[..., 0])


def find_spots(room: Room, camera: Camera, name: str, picture: Array, ball: Ball) -> list[Spot]:
    """Blobs of one target in one camera: near its prediction, or anywhere while it is lost."""
    left, top = 0, 0
    center = None
    if ball.place is not None:
        center = image(camera, ball.place + ball.velocity * PERIOD)
        reach = max(SEARCH_PX, 1.5 * float(np.linalg.norm(center - image(camera, ball.place))))
        half = int(reach) + 10
        left, top = (max(int(c) - half, 0) for c in center)
        picture = picture[top : max(int(center[1]) + half, 0), left : max(int(center[0]) + half, 0)]
        if picture.size == 0:
            return []
    level = target_level(room, camera, name, picture)
    edge = COLOR_EDGE if camera.kind == "color" else INFRARED_EDGE
    peak = cv2.dilate(level, np.ones((9, 9), np.uint8))
    mask = ((level > 0) & (level >= edge * peak)).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    smallest, largest = room.targets[name].area[camera.name]
    spots = []
    for label in range(1, count):
        if not 0.3 * smallest <= stats[label, cv2.CC_STAT_AREA] <= 1.5 * largest:
            continue
        y, x = np.nonzero(labels == label)
        if camera.kind == "color" and similarity(room, camera, name, picture[y, x, 0]) < SIMILARITY:
            continue
        weight = level[y, x].astype(float)
        pixel = np.array([(weight * x).sum(), (weight * y).sum()]) / weight.sum()
        if ball.place is not None:
            radius = outline(room, camera, name, ball.place) + (0 if camera.kind == "color" else -0.5)
            pixel = disc_center(level, labels == label, pixel, radius, edge)
        pixel += [left, top]
        if center is None or np.linalg.norm(pixel - center) <= reach:
            K = camera.matrix
            xy = cv2.undistortPoints(pixel.reshape(1, 1, 2), K, camera.distortion, P=K)[0, 0]
            spots.append(Spot(pixel, xy))
    return spots


def outline(room: Room, camera: Camera, name: str, place: Array) -> float:
    """Radius of the target in the picture, px."""
    side = place + camera.rotation[0] * room.targets[name].radius
    return float(np.linalg.norm(image(camera, side) - image(camera, place)))


def disc_center(level: Array, blob: Array, start: Array, radius: float, edge: float) -> Array:
    """Centre of the disc of known radius that most edge pixels of a blob vote for."""
    smooth = cv2.GaussianBlur(level.astype(np.float32), (3, 3), 0.8)
    across, down = cv2.Scharr(smooth, -1, 1, 0, scale=1 / 32), cv2.Scharr(smooth, -1, 0, 1, scale=1 / 32)
    y, x = np.nonzero(cv2.dilate(blob.astype(np.uint8), np.ones((3, 3), np.uint8)))
    peak = float(level[blob].max())
    slope = np.hypot(across[y, x], down[y, x]) + 1e-6
    inside = (smooth[y, x] - edge * peak) / slope
    voter = (np.abs(inside) < 1.2) & (slope > 0.08 * peak)
    if not voter.any():
        return start
    x, y, slope, inside = x[voter], y[voter], slope[voter], inside[voter]
    step = ((radius - inside) / slope)[:, None]
    vote = np.column_stack([x, y]) + step * np.column_stack([across[y, x], down[y, x]])
    center = start
    for spread in (2.0, 1.4, 1.0, 0.8):
        weight = slope / (1 + ((vote - center) ** 2).sum(axis=1) / spread**2) ** 2
        center = (weight[:, None] * vote).sum(axis=0) / weight.sum()
    return np.asarray(center)


def target_level(room: Room, camera: Camera, name: str, picture: Array) -> Array:
    """Brightness of the pixels that may show the target, 0 elsewhere."""
    target = room.targets[name]
    if camera.kind != "color":
        low, high = target.gray[camera.name]
        return np.where((picture >= low) & (picture <= high), picture, 0).astype(np.uint8)
    member = np.repeat(np.asarray(target.hue_histogram[camera.name]) >= 0.02, 16)
    hue, saturation, value = cv2.split(picture)
    shown = member[hue] & (saturation >= 80) & (value >= 70)
    return np.where(shown, value, 0).astype(np.uint8)


def similarity(room: Room, camera: Camera, name: str, hue: Array) -> float:
    """Bhattacharyya coefficient of a blob's hue histogram with the template."""
    histogram = np.bincount(hue >> 4, minlength=16) / len(hue)
    return float(np.sqrt(histogram * room.targets[name].hue_histogram[camera.name]).sum())


def image(camera: Camera, point: Array) -> Array:
    """Image of a point of the room."""
    rotation = cv2.Rodrigues(camera.rotation)[0]
    pixel, _ = cv2.projectPoints(point[None], rotation, camera.translation, camera.matrix, camera.distortion)
    return np.asarray(pixel[0, 0])


def candidates(
    room: Room,
    name: str,
    spots: Mapping[tuple[str, str], list[Spot]],
    pairs: Sequence[tuple[Camera, Camera]],
    F: Mapping[tuple[str, str], Array],
    H: Mapping[tuple[str, str], list[Array]],
    ball: Ball,
) -> tuple[list[Array], list[float]]:
    """3D points of all pairs of spots that pass the tests, and their weights."""
    points: list[Array] = []
    weights: list[float] = []
    for a, b in pairs:
        if ball.place is None and a.kind == b.kind:
            continue
        for one in spots[a.name, name]:
            for other in spots[b.name, name]:
                distance = epipolar(F[a.name, b.name], one.xy, other.xy)
                if distance >= EPIPOLAR_PX:
                    continue
                if a.kind == b.kind == "color" and on_plane(H[a.name, b.name], one.xy, other.xy):
                    continue
                X = cv2.triangulatePoints(a.projection, b.projection, one.xy[:, None], other.xy[:, None])
                point = X[:3, 0] / X[3, 0]
                if ball.place is not None:
                    predicted = ball.place + ball.velocity * PERIOD
                    reach = max(SEARCH_M, 2 * float(np.linalg.norm(ball.velocity)) * PERIOD)
                    if np.linalg.norm(point - predicted) > reach:
                        continue
                points.append(point)
                weights.append(float(np.exp(-(distance**2) / 2)))
    return points, weights


def epipolar(F: Array, one: Array, other: Array) -> float:
    """Larger distance of two points from each other's epipolar line, px."""
    line2, line1 = F @ np.append(one, 1), F.T @ np.append(other, 1)
    algebraic = abs(float(np.append(other, 1) @ line2))
    return algebraic / float(min(np.hypot(*line1[:2]), np.hypot(*line2[:2])))


def on_plane(homographies: Sequence[Array], one: Array, other: Array) -> bool:
    """True if a pair satisfies one of the planes, as a projection on it would."""
    for H in homographies:
        moved = H @ np.append(one, 1)
        if np.linalg.norm(moved[:2] / moved[2] - other) < PLANE_PX:
            return True
    return False


def fuse(points: Sequence[Array], weights: Sequence[float], ball: Ball) -> Array | None:
    """Mean shift from the prediction, or from the heaviest point of a lost target."""
    if not points:
        return None
    sample, weight = np.array(points), np.array(weights)
    center = sample[weight.argmax()]
    if ball.place is not None:
        center = ball.place + ball.velocity * PERIOD
    for _ in range(30):
        inside = np.linalg.norm(sample - center, axis=1) < BANDWIDTH_M
        chosen = inside if inside.any() else np.ones(len(sample), bool)
        mean = np.average(sample[chosen], axis=0, weights=weight[chosen])
        moved = np.linalg.norm(mean - center)
        center = mean
        if moved < RESTS_M:
            break
    return np.asarray(center)


def follow(ball: Ball, position: Array | None) -> None:
    """Constant velocity with fixed gains; a ball that is missing for too long is lost."""
    if position is None:
        ball.unseen += 1
        ball.velocity = np.zeros(3)
        if ball.unseen > MISSING_FRAMES:
            ball.place = None
        return
    if ball.place is None:
        ball.place, ball.velocity = position, np.zeros(3)
    else:
        predicted = ball.place + ball.velocity * PERIOD
        residual = position - predicted
        ball.place, ball.velocity = predicted + 0.8 * residual, ball.velocity + 0.5 * residual / PERIOD
    ball.unseen = 0
