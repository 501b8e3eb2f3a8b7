"""Multi-view geometry after Hartley & Zisserman: projection, undistortion, triangulation, pair relations.

All functions are pure and vectorised over points. `pixel` names points in the picture, with lens distortion;
`xy` names undistorted points, images of a pinhole camera with the same matrix K. A point without an image
(behind the camera) is NaN. The lens models themselves stand in `followspot.lens`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from followspot.lens import (
    POLYNOMIAL,
    PROJECT,
    fold,
    local_rays,
    normalise,
    pinhole_image,
    undistort_polynomial,
)
from followspot.messages import Array
from followspot.room import Camera


def project(camera: Camera, points: Array) -> Array:
    """Images of points of the room.

    points: (N, 3) m. Returns (N, 2) px with distortion; NaN for points behind a pinhole camera.
    """
    return project_local(camera, points @ camera.rotation.T + camera.translation)


def project_local(camera: Camera, local: Array) -> Array:
    """Images of points in camera coordinates, x_cam = R X + t: (N, 3) m -> (N, 2) px with distortion."""
    return PROJECT[camera.model](camera, local)


class Views:
    """Several cameras, to project the same points into all of them.

    Results keep each coordinate contiguous in memory, which makes arithmetic faster.
    """

    def __init__(self, cameras: Iterable[Camera]) -> None:
        self.cameras = tuple(cameras)
        self.others = [i for i, c in enumerate(self.cameras) if c.model != "pinhole" or c.matrix[0, 1] != 0]
        rotation = np.array([c.rotation for c in self.cameras]).reshape(-1, 3, 3)
        translation = np.array([c.translation for c in self.cameras]).reshape(-1, 3)
        self.rotation = rotation.swapaxes(0, 1).reshape(-1, 3)
        self.translation = translation.T.reshape(-1, 1)
        lens = [c.distortion if c.model == "pinhole" else np.zeros(5) for c in self.cameras]
        K = np.array([c.matrix for c in self.cameras]).reshape(-1, 9)[:, [0, 2, 4, 5]]
        self.lens = np.hstack([np.reshape(lens, (-1, 5)), K]).T[..., None]
        self.fold = np.array([fold(c) for c in self.cameras]).reshape(-1, 1)
        self.size = np.array([c.size for c in self.cameras]).reshape(-1, 1, 2)

    def local(self, points: Array) -> Array:
        """Camera coordinates: (N, 3) m in the room -> (C, N, 3) m."""
        local = self.rotation @ points.T + self.translation
        return np.asarray(local.reshape(3, len(self.cameras), len(points)).transpose(1, 2, 0))

    def project_local(self, local: Array) -> Array:
        """Images of points in camera coordinates, as :func:`project_local`: (C, N, 3) m -> (C, N, 2) px."""
        k1, k2, p1, p2, k3, fx, cx, fy, cy = self.lens.repeat(local.shape[1], axis=2)
        depth = np.where(local[..., 2] > 0, local[..., 2], np.nan)
        x, y = local[..., 0] / depth, local[..., 1] / depth
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3)) + 2 * (p2 * x + p1 * y)
        pixel = np.empty((2, *r2.shape)).transpose(1, 2, 0)
        pixel[..., 0] = (x * radial + p2 * r2) * fx + cx
        pixel[..., 1] = (y * radial + p1 * r2) * fy + cy
        for i in self.others:
            pixel[i] = project_local(self.cameras[i], local[i])
        return np.asarray(pixel)

    def in_pictures(self, points: Array) -> Array:
        """Which cameras have which points of the room in their pictures: (N, 3) m -> (C, N) bool."""
        local = self.local(points)
        pixel = self.project_local(local)  # NaN behind a camera is in no picture
        across = np.hypot(local[..., 0], local[..., 1])
        unfolded = across / self.fold <= np.abs(local[..., 2])
        return np.asarray(((pixel >= 0) & (pixel < self.size)).all(axis=2) & unfolded)


def undistort(camera: Camera, pixel: Array) -> Array:
    """Remove the lens distortion: (N, 2) px -> (N, 2) px of a pinhole camera with the same K.

    NaN for a pixel whose ray does not point forward (wide fisheye, panorama).
    """
    if camera.model in POLYNOMIAL:
        return undistort_polynomial(camera, pixel)
    return pinhole_image(camera, local_rays(camera, pixel))


def distort(camera: Camera, xy: Array) -> Array:
    """Inverse of :func:`undistort`: (N, 2) px without distortion -> (N, 2) px in the picture."""
    normalised = normalise(camera, xy)
    return PROJECT[camera.model](camera, np.column_stack([normalised, np.ones(len(xy))]))


def ray(camera: Camera, pixel: Array) -> Array:
    """Viewing directions in the room: (N, 2) px with distortion -> (N, 3) unit vectors from the centre."""
    directions = local_rays(camera, pixel) @ camera.rotation
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def depth_rays(camera: Camera) -> Array:
    """Viewing direction of every pixel, of unit depth: (H, W, 3), so long that the camera's z is 1.

    The point of the room at depth z along the optical axis is `camera.center + z * depth_rays(camera)[v, u]`.
    NaN for a pixel whose ray does not point forward (wide fisheye, panorama).
    """
    width, height = camera.size
    y, x = np.mgrid[:height, :width].astype(float)
    rays = ray(camera, np.column_stack([x.ravel(), y.ravel()]))
    ahead = rays @ camera.rotation[2]
    rays /= np.where(ahead > 0, ahead, np.nan)[:, None]
    return rays.reshape(height, width, 3)


def wrap(angle: Array) -> Array:
    """Angles wrapped to [-pi, pi), rad; any shape."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def direction(offset: Array) -> Array:
    """Direction of (..., 2) m seen from above, counter-clockwise from the x axis: (...) rad."""
    return np.asarray(np.arctan2(offset[..., 1], offset[..., 0]))


def seen_from_above(camera: Camera, xy: Array) -> tuple[Array, Array]:
    """Direction from the optical axis (rad, positive to the left) and horizontal distance (m) of (..., 2) m.

    The axis of a panorama is its middle column.
    """
    offset = xy - camera.center[:2]
    axis = direction(camera.rotation[2, :2])
    return wrap(direction(offset) - axis), np.hypot(offset[..., 0], offset[..., 1])


def back_projection(camera: Camera) -> Array:
    """M^-1, (3, 3), with P = [M | p4]: the ray of an undistorted pixel is M^-1 (x, y, 1) (H&Z eq. 6.14)."""
    return np.asarray(np.linalg.inv(camera.projection[:, :3]))


def fundamental_matrix(P1: Array, P2: Array) -> Array:
    """F with x2^T F x1 = 0 for the undistorted images of one point (H&Z, table 9.1), of unit norm.

    P1, P2: (3, 4). Returns (3, 3).
    """
    center = np.append(-np.linalg.solve(P1[:, :3], P1[:, 3]), 1.0)
    F = cross_matrix(P2 @ center) @ P2 @ np.linalg.pinv(P1)
    return np.asarray(F / np.linalg.norm(F))


def plane_homography(a: Camera, b: Camera, plane: Array) -> Array:
    """H that maps undistorted pixels of points on a plane from camera a to camera b (H&Z, section 13.1).

    plane: (4,) with unit normal, m. Returns (3, 3), of unit norm. Camera a must not lie in the plane.
    """
    center = np.append(a.center, 1.0)
    directions = np.vstack([back_projection(a), np.zeros(3)])
    H = b.projection @ (directions * (plane @ center) - np.outer(center, plane @ directions))
    return np.asarray(H / np.linalg.norm(H))


def epipolar_distance(F: Array, xy1: Array, xy2: Array) -> Array:
    """Distance of two points from each other's epipolar line: the larger of the two views, px.

    F: (3, 3) or one for each pair (N, 3, 3); xy1, xy2: (N, 2) px undistorted. Returns (N,).
    """
    line2 = _times(F, xy1)
    line1 = _times(np.swapaxes(F, -1, -2), xy2)
    algebraic = np.abs(line2[..., 0] * xy2[..., 0] + line2[..., 1] * xy2[..., 1] + line2[..., 2])
    slope = np.minimum(np.hypot(line1[..., 0], line1[..., 1]), np.hypot(line2[..., 0], line2[..., 1]))
    return np.asarray(algebraic / np.maximum(slope, np.finfo(float).tiny))


def transfer(H: Array, xy: Array) -> Array:
    """Map points by a homography. H: (..., 3, 3); xy: (..., 2) px. Returns (..., 2) px."""
    image = _times(H, xy)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(image[..., :2] / image[..., 2:])


def triangulate_pairs(centers: Array, rays: Array) -> Array:
    """The point between two rays that divides their common perpendicular by the squared depths.

    Equal errors in angle in both views are assumed, hence the division; for rays that meet it is the
    exact point. centers: (N, 2, 3) m; rays: (N, 2, 3), unit vectors. Returns (N, 3) m; NaN where the
    rays are parallel or meet behind a camera.
    """
    baseline = centers[:, 1] - centers[:, 0]
    d1, d2 = rays[:, 0], rays[:, 1]
    cosine = np.vecdot(d1, d2)
    along1 = np.vecdot(baseline, d1)
    along2 = np.vecdot(baseline, d2)
    with np.errstate(divide="ignore", invalid="ignore"):
        sine2 = 1.0 - cosine * cosine
        depth1 = (along1 - cosine * along2) / sine2
        depth2 = (cosine * along1 - along2) / sine2
        share = (depth1 / np.hypot(depth1, depth2)) ** 2
        first = centers[:, 0] + depth1[:, None] * d1
        second = centers[:, 1] + depth2[:, None] * d2
        points = first + share[:, None] * (second - first)
    points[~((depth1 > 0) & (depth2 > 0))] = np.nan
    return np.asarray(points)


def triangulate_views(centers: Array, rays: Array, weights: Array) -> Array:
    """Points nearest to their rays in all views: minimise sum w |(I - d d^T)(X - C)|^2.

    centers: (V, 3) or (N, V, 3) m; rays: (N, V, 3), unit vectors; weights: (N, V), 0 for a view that
    does not see the point; for equal errors in angle they are 1 / depth^2. Returns (N, 3) m.
    Raises numpy.linalg.LinAlgError if fewer than two views see a point.
    """
    across = weights[..., None, None] * (np.eye(3) - rays[..., :, None] * rays[..., None, :])
    normal = across.sum(axis=-3)
    moment = (across @ np.broadcast_to(centers, rays.shape)[..., None]).sum(axis=-3)
    return np.asarray(np.linalg.solve(normal, moment)[..., 0])


def cross_matrix(v: Array) -> Array:
    """[v]_x with [v]_x w = v x w (H&Z, eq. A4.5). v: (3,). Returns (3, 3)."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _times(matrix: Array, xy: Array) -> Array:
    """M (x, y, 1), (..., 3), as a sum of columns, because numpy multiplies many small matrices slowly."""
    return np.asarray(matrix[..., 0] * xy[..., :1] + matrix[..., 1] * xy[..., 1:] + matrix[..., 2])
