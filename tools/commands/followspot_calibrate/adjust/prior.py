"""Cameras as they are believed to be before an adjustment, each parameter with its sigma."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.geometry import cross_matrix
from followspot.messages import Array
from followspot_calibrate.adjust.projection import Free


@dataclass(frozen=True, eq=False)
class Prior:
    """C cameras, and how well each of their free parameters is known.

    sigma: (C, P) in the order of `Free`: direction (rad), centre (m), log focal length (1), log aspect (1),
    principal point (px), distortion (1). Poses must be free.
    """

    cameras: Sequence[Camera]
    sigma: Array

    def errors(self, number: int, camera: Camera, free: Free) -> Array:
        """Deviation of a camera from its prior, (P,) sigmas."""
        given = self.cameras[number]
        parts = [rotation_vector(camera.rotation @ given.rotation.T), camera.center - given.center]
        if free.focal:
            parts.append(np.log(camera.matrix[:1, 0] / given.matrix[0, 0]))
        if free.aspect:
            parts.append(np.log(aspect(camera) / aspect(given)))
        if free.center:
            parts.append(camera.matrix[:2, 2] - given.matrix[:2, 2])
        lens = slice(free.distortion)
        parts.append(camera.distortion[lens] - given.distortion[lens])
        return np.asarray(np.concatenate(parts) / self.sigma[number, : free.parameters])

    def by_parameters(self, number: int, camera: Camera, free: Free) -> Array:
        """Derivative of the errors by the parameters, (P, P); turns are small."""
        rows = np.eye(free.parameters)
        rows[3:6, :6] = -camera.rotation.T @ np.hstack([cross_matrix(camera.translation), np.eye(3)])
        return np.asarray(rows / self.sigma[number, : free.parameters, None])


def aspect(camera: Camera) -> Array:
    """Focal length along y over that along x, (1,)."""
    return np.asarray(camera.matrix[1:2, 1] / camera.matrix[0, 0])


def rotation_vector(rotation: Array) -> Array:
    """Axis times angle of a rotation, (3, 3) -> (3,) rad (H&Z, appendix A4.3.2)."""
    import cv2

    return np.asarray(cv2.Rodrigues(rotation)[0][:, 0])
