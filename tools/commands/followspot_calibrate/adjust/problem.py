"""The cost of an adjustment: robust reprojection and length errors, and their normal equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.geometry import cross_matrix, undistort
from followspot.messages import Array
from followspot_calibrate.adjust.elimination import Normal
from followspot_calibrate.adjust.prior import Prior
from followspot_calibrate.adjust.projection import Free, image, linearise, moved
from followspot_calibrate.adjust.rods import Group, Rods


@dataclass(frozen=True, eq=False)
class View:
    """Sightings of one camera. rows: (M,) of the points; pixel: (M, 2) px; free: its parameters."""

    rows: Array
    pixel: Array
    free: Free


def view_of(camera: Camera, pixel: Array, free: Free) -> tuple[Camera, View]:
    """A camera and its view of N points, (N, 2) px, NaN if not seen.

    A camera of another model becomes a pinhole of undistorted points, of which only the pose is free.
    """
    if camera.model != "pinhole":
        pixel = undistort(camera, pixel)
        camera = replace(camera, model="pinhole", distortion=np.zeros(5))
        free = Free(poses=free.poses)
    rows = np.flatnonzero(np.isfinite(pixel).all(axis=1))
    return camera, View(rows, pixel[rows], free)


@dataclass(frozen=True, eq=False)
class Estimate:
    """A guess: C cameras and points (N, 3) m."""

    cameras: tuple[Camera, ...]
    points: Array


@dataclass(frozen=True, eq=False)
class Middle:
    """Expected principal points, (C, 2) px, with sigma, (C,) px."""

    center: Array
    sigma: Array


@dataclass(frozen=True, eq=False)
class Anchors:
    """Known camera centres, (C, 3) m, with sigma, (C,) m, infinite if unknown."""

    center: Array
    sigma: Array

    def errors(self, cameras: Sequence[Camera]) -> Array:
        """Deviation of centres from their known places, (C, 3) sigmas."""
        away = np.array([camera.center for camera in cameras]) - self.center
        return np.where(np.isfinite(self.sigma)[:, None], away / self.sigma[:, None], 0.0)

    def by_pose(self, cameras: Sequence[Camera]) -> Array:
        """Derivative of the errors by the poses: (C, 3, 6)."""
        rows = [
            -camera.rotation.T @ np.hstack([cross_matrix(camera.translation), np.eye(3)])
            for camera in cameras
        ]
        return np.array(rows) / self.sigma[:, None, None]


@dataclass(frozen=True, eq=False)
class Problem:
    """Observations, known lengths and, for each point, the error in px that begins to count as an outlier.

    scale: (N,) px; parameters: the most that any camera has free; groups: the points as rods tie them.
    """

    views: Sequence[View]
    rods: Rods
    groups: Sequence[Group]
    scale: Array
    parameters: int
    middle: Middle | None = None
    anchors: Anchors | None = None
    prior: Prior | None = None

    def cost(self, estimate: Estimate) -> float:
        """Sum of the Cauchy losses log(1 + e^2) of all errors e, in scales and sigmas."""
        total = np.log1p(np.square(self.rods.errors(estimate.points)[0])).sum()
        for view, camera in zip(self.views, estimate.cameras, strict=True):
            error = (image(camera, estimate.points[view.rows]) - view.pixel) / self.scale[view.rows, None]
            total += np.log1p(np.square(error).sum(axis=1)).sum()
        if self.anchors is not None:
            total += np.square(self.anchors.errors(estimate.cameras)).sum()
        if self.prior is not None:
            for number, (view, camera) in enumerate(zip(self.views, estimate.cameras, strict=True)):
                total += np.square(self.prior.errors(number, camera, view.free)).sum()
        return float(total + np.square(self._off_middle(estimate.cameras)).sum())

    def step(self, normal: Normal, estimate: Estimate, damping: float) -> Estimate | None:
        """The estimate after one damped step, or None if the damping is too small."""
        try:
            by_camera, by_point = normal.solve(self.groups, damping)
        except np.linalg.LinAlgError:
            return None
        cameras = tuple(
            moved(camera, step[: view.free.parameters], view.free)
            for view, camera, step in zip(self.views, estimate.cameras, by_camera, strict=True)
        )
        return Estimate(cameras, estimate.points + by_point)

    def normal(self, estimate: Estimate) -> Normal:
        """The normal equations of the Cauchy losses; rods have the weight 1 / (1 + e^2) alone."""
        normal = Normal.zeros(len(self.views), self.parameters, len(estimate.points), len(self.rods))
        for number, (view, camera) in enumerate(zip(self.views, estimate.cameras, strict=True)):
            self._add_view(normal, number, view, camera, estimate.points)
            if self.prior is not None:
                rows = self.prior.by_parameters(number, camera, view.free)
                normal.cameras[number, : len(rows), : len(rows)] += rows.T @ rows
                errors = self.prior.errors(number, camera, view.free)
                normal.toward_cameras[number, : len(rows)] -= rows.T @ errors
        self._add_rods(normal, estimate.points)
        if self.anchors is not None:
            rows = self.anchors.by_pose(estimate.cameras)
            normal.cameras[:, :6, :6] += rows.swapaxes(1, 2) @ rows
            errors = self.anchors.errors(estimate.cameras)
            normal.toward_cameras[:, :6] -= (errors[:, None] @ rows)[:, 0]
        if self.middle is not None:
            off = self._off_middle(estimate.cameras)
            for number, view in enumerate(self.views):
                at, sigma = view.free.center_at, self.middle.sigma[number]
                normal.cameras[number, at, at] += np.eye(at.stop - at.start) / sigma**2
                normal.toward_cameras[number, at] -= off[number, : at.stop - at.start] / sigma
        return normal

    def _off_middle(self, cameras: Sequence[Camera]) -> Array:
        """Deviation of principal points from the expected ones, (C, 2) sigmas."""
        if self.middle is None:
            return np.zeros((len(cameras), 2))
        centers = np.array([camera.matrix[:2, 2] for camera in cameras])
        return np.asarray((centers - self.middle.center) / self.middle.sigma[:, None])

    def _add_view(self, normal: Normal, number: int, view: View, camera: Camera, points: Array) -> None:
        at, by_camera, by_point = linearise(camera, points[view.rows], view.free)
        scale = self.scale[view.rows, None]
        weighted, error = cauchy_weighted((view.pixel - at) / scale)
        weighted /= scale[..., None]
        by_camera, by_point = _products(weighted, by_camera), _products(weighted, by_point)
        size = view.free.parameters
        flat = by_camera.reshape(2 * len(view.rows), size)
        normal.cameras[number, :size, :size] = flat.T @ flat
        normal.toward_cameras[number, :size] = flat.T @ error.ravel()
        first = number * self.parameters
        normal.mixed[view.rows, :, first : first + size] = _products(by_point, by_camera)
        normal.points[view.rows] += _products(by_point, by_point)
        normal.toward_points[view.rows] += _products(by_point, error[..., None])[..., 0]

    def _add_rods(self, normal: Normal, points: Array) -> None:
        error, direction = self.rods.errors(points)
        weight = (1 / (1 + np.square(error)))[:, None]
        block = (weight * direction)[:, :, None] * direction[:, None]
        toward = -weight * error[:, None] * direction
        for end, sign in ((self.rods.first, 1.0), (self.rods.second, -1.0)):
            np.add.at(normal.points, end, block)
            np.add.at(normal.toward_points, end, sign * toward)
        normal.rods[:] = -block


def cauchy_weighted(error: Array) -> tuple[Array, Array]:
    """Factors W (M, 2, 2) of derivatives J, and errors r (M, 2), such that (WJ)^T r is the gradient of the
    Cauchy loss, and (WJ)^T WJ nearly its second derivative for small errors. error: (M, 2).

    The weight 1 / (1 + e^2) alone overrates the curvature along an error, and steps would be too short. The
    true one, (1 - e^2) / (1 + e^2) of it, is negative for outliers; (1 + e^4) / (1 + e^2)^2 is the same for
    small errors and has no effect on large ones. Triggs et al., "Bundle adjustment: a modern synthesis"
    (2000), section 4.3.
    """
    square = np.square(error).sum(axis=1)[:, None]
    root = 1 / np.sqrt(1 + square)
    along = np.sqrt(1 + np.square(square)) / (1 + square)
    shorter = root * (1 - along) / np.maximum(square, np.finfo(float).tiny)
    factor = -(shorter * error)[:, :, None] * error[:, None]
    factor[:, (0, 1), (0, 1)] += root
    return factor, error * root / along


def _products(a: Array, b: Array) -> Array:
    """a^T b of each observation: (M, 2, A), (M, 2, B) -> (M, A, B); faster than many small products."""
    return np.asarray(a[:, 0, :, None] * b[:, 0, None] + a[:, 1, :, None] * b[:, 1, None])
