"""The pinhole camera with OpenCV's lens model and its derivatives (Hartley & Zisserman, appendix 6)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.geometry import cross_matrix
from followspot.messages import Array
from followspot.rotation import cross


@dataclass(frozen=True)
class Free:
    """Which parameters of every camera an adjustment may change.

    focal: one factor for fx and fy, so square pixels stay square; aspect: one for fy alone; distortion: how
    many of the leading coefficients, 0 (none), 1 (k1), 2 (k1 k2), 4 (and p1 p2) or 5 (and k3).
    """

    poses: bool = True
    focal: bool = False
    aspect: bool = False
    center: bool = False
    distortion: int = 0

    def __post_init__(self) -> None:
        if self.distortion not in (0, 1, 2, 4, 5):
            raise ValueError(f"distortion frees 0, 1, 2, 4 or 5 coefficients, not {self.distortion}")

    @property
    def center_at(self) -> slice:
        """Index of the principal point among the parameters."""
        first = 6 * self.poses + self.focal + self.aspect
        return slice(first, first + 2 * self.center)

    @property
    def intrinsics(self) -> bool:
        """True if anything but the poses is free."""
        return self.focal or self.aspect or self.center or self.distortion > 0

    @property
    def parameters(self) -> int:
        """Number, in this order: rotation 3, translation 3, log focal 1, aspect 1, center 2, lens."""
        return 6 * self.poses + self.focal + self.aspect + 2 * self.center + self.distortion


def image(camera: Camera, points: Array) -> Array:
    """Pixels of points: (M, 3) m -> (M, 2) px. Points behind the camera have one too, as in the formula."""
    local = points @ camera.rotation.T + camera.translation
    distorted = _distorted(camera.distortion, local[:, :2] / local[:, 2:])
    return np.asarray(_pixels(camera, distorted) + camera.matrix[:2, 2])


def linearise(camera: Camera, points: Array, free: Free) -> tuple[Array, Array, Array]:
    """Pixels of points and how they change.

    points: (M, 3) m. Returns (M, 2) px, its derivatives by the camera's free parameters, (M, 2, P), and by
    the point, (M, 2, 3). The rotation's parameters are a rotation vector applied after R.
    """
    turned = points @ camera.rotation.T
    local = turned + camera.translation
    xy = local[:, :2] / local[:, 2:]
    lens = _by_coefficients(xy)
    distorted = xy + lens @ camera.distortion
    by_local = np.empty((len(points), 2, 3))
    by_local[:, :, :2] = _pixels(camera, _by_xy(camera.distortion, xy)) / local[:, 2, None, None]
    by_local[:, :, 2] = -(by_local[:, :, :2] @ xy[..., None])[..., 0]
    parts = []
    if free.poses:
        parts += [cross(turned[:, None], by_local), by_local]
    by_focal = distorted * np.diagonal(camera.matrix)[:2]
    if free.focal:
        parts.append(by_focal[..., None])
    if free.aspect:
        parts.append((by_focal * [0.0, 1.0])[..., None])
    if free.center:
        parts.append(np.broadcast_to(np.eye(2), (len(points), 2, 2)))
    parts.append(_pixels(camera, lens[..., : free.distortion]))
    pixel = _pixels(camera, distorted) + camera.matrix[:2, 2]
    return pixel, np.concatenate(parts, axis=2), by_local @ camera.rotation


def moved(camera: Camera, step: Array, free: Free) -> Camera:
    """The camera after a change of its free parameters, (P,)."""
    rest = step
    if free.poses:
        turn, shift, rest = rest[:3], rest[3:6], rest[6:]
        rotation, translation = rotation_of(turn) @ camera.rotation, camera.translation + shift
        camera = replace(camera, rotation=rotation, translation=translation)
    if not free.intrinsics:
        return camera
    matrix = camera.matrix.copy()
    if free.focal:
        matrix[[0, 1], [0, 1]] *= np.exp(rest[0])
        rest = rest[1:]
    if free.aspect:
        matrix[1, 1] *= np.exp(rest[0])
        rest = rest[1:]
    if free.center:
        matrix[:2, 2] += rest[:2]
        rest = rest[2:]
    distortion = camera.distortion + np.pad(rest, (0, 5 - len(rest)))
    return replace(camera, matrix=matrix, distortion=distortion)


def rotation_of(vector: Array) -> Array:
    """Rotation by |v| radians about v (Rodrigues; H&Z, eq. A4.9). vector: (3,). Returns (3, 3)."""
    angle = float(np.linalg.norm(vector))
    if angle < np.finfo(float).tiny:
        return np.eye(3)
    K = cross_matrix(vector / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def _pixels(camera: Camera, normalised: Array) -> Array:
    """Points in focal lengths, (M, 2), or their derivatives, (M, 2, P), in px from the principal point."""
    focal, skew = np.diagonal(camera.matrix)[:2], camera.matrix[0, 1]
    scaled = normalised * (focal if normalised.ndim == 2 else focal[:, None])
    if skew:
        scaled[:, 0] += skew * normalised[:, 1]
    return np.asarray(scaled)


def _distorted(distortion: Array, xy: Array) -> Array:
    return np.asarray(xy + _by_coefficients(xy) @ distortion)


def _by_coefficients(xy: Array) -> Array:
    """Derivative of distorted by k1 k2 p1 p2 k3, (M, 2, 5); the lens model is linear in them."""
    x, y = xy[:, 0], xy[:, 1]
    r2 = x * x + y * y
    cross = 2 * x * y
    rows = np.empty((len(xy), 2, 5))
    rows[:, :, 0] = xy * r2[:, None]
    rows[:, :, 1] = rows[:, :, 0] * r2[:, None]
    rows[:, 0, 2], rows[:, 1, 2] = cross, r2 + 2 * y * y
    rows[:, 0, 3], rows[:, 1, 3] = r2 + 2 * x * x, cross
    rows[:, :, 4] = rows[:, :, 1] * r2[:, None]
    return rows


def _by_xy(distortion: Array, xy: Array) -> Array:
    """Derivative of distorted by undistorted normalised points, (M, 2, 2); symmetric."""
    k1, k2, p1, p2, k3 = distortion
    x, y = xy[:, 0], xy[:, 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))
    rows = np.empty((len(xy), 2, 2))
    rows[:, 0, 0] = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x
    rows[:, 1, 1] = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x
    rows[:, 0, 1] = rows[:, 1, 0] = x * y * slope + 2 * p1 * x + 2 * p2 * y
    return rows
