"""The frame of reference of a room: moved as a whole, so that a plane of it becomes the floor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.messages import Array

STEEP = 0.9
"""Cosine of the angle to the floor's normal above which the old x axis says nothing about the new one."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A rigid motion of the room: X_new = rotation X_old + shift; (3, 3), (3,) m."""

    rotation: Array
    shift: Array

    def camera(self, camera: Camera) -> Camera:
        """The camera in the new frame; it sees the same."""
        rotation = camera.rotation @ self.rotation.T
        return replace(camera, rotation=rotation, translation=camera.translation - rotation @ self.shift)

    def plane(self, plane: Array) -> Array:
        """The plane in the new frame."""
        normal = self.rotation @ plane[:3]
        return np.append(normal, plane[3] - normal @ self.shift)

    def points(self, points: Array) -> Array:
        """Points in the new frame, (N, 3) m."""
        return np.asarray(points @ self.rotation.T + self.shift)

    def cameras(self, cameras: Mapping[str, Camera]) -> dict[str, Camera]:
        """All cameras in the new frame."""
        return {name: self.camera(camera) for name, camera in cameras.items()}


def onto_floor(plane: Array) -> Motion:
    """The motion that makes a plane z = 0, its normal z.

    The new x axis is the old one laid onto the plane (the old y axis, where x stands upright on it), the new
    origin the point of the plane below the old origin.
    """
    up = plane[:3]
    along = np.eye(3)[0 if abs(up[0]) < STEEP else 1]
    x = along - up * (along @ up)
    x /= np.linalg.norm(x)
    rotation = np.array([x, np.cross(up, x), up])
    return Motion(rotation, np.array([0.0, 0.0, plane[3]]))
