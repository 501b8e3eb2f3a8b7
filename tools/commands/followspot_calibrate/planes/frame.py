"""The frame of reference of a room, moved as a whole, so that a plane of it becomes the floor."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot_calibrate.similarity import Similarity

STEEP = 0.9
"""Cosine of the angle to the floor's normal above which the old x axis says nothing about the new one."""


def onto_floor(plane: Array) -> Similarity:
    """The rigid motion that makes a plane z = 0, its normal z.

    The new x axis is the projection of the old one on the plane (of the old y axis if x is perpendicular to
    it), the new origin the point of the plane below the old origin.
    """
    up = plane[:3]
    along = np.eye(3)[0 if abs(up[0]) < STEEP else 1]
    x = along - up * (along @ up)
    x /= np.linalg.norm(x)
    return Similarity(np.array([x, np.cross(up, x), up]), np.array([0.0, 0.0, plane[3]]))


def moved_plane(plane: Array, motion: Similarity) -> Array:
    """A plane (4,) in the new frame of a rigid motion."""
    normal = motion.rotation @ plane[:3]
    return np.append(normal, plane[3] - normal @ motion.shift)
