"""The expected area of a whole target's blob in each camera."""

from __future__ import annotations

import numpy as np

from followspot.geometry import project_local
from followspot.messages import Array
from followspot.room import Camera, Room
from followspot_balls.measurement.bright_part import bright_part

STEP = np.radians(0.5)
"""Step of the angle off the axis in the table of a lens."""
STEPS = 179
"""Angles in it: all before a camera."""


def unit_outline(room: Room) -> Array:
    """Area of the blob of a whole ball of unit radius at unit distance in each camera: (C,) px."""
    focal = np.array([c.matrix[0, 0] for c in room.cameras.values()])
    return np.asarray(np.pi * np.square(focal) * bright_part(room))


class Stretch:
    """How much larger the lenses of C cameras draw a small ball aside of the axis than on it.

    Both at one distance: a pinhole camera draws it 1 / cos^3 of the angle as large, most lenses with barrel
    distortion hardly larger.
    """

    def __init__(self, room: Room) -> None:
        self.table = np.array([stretch_by_angle(c) for c in room.cameras.values()]).reshape(-1, STEPS)

    def at(self, camera: Array, secant2: Array) -> Array:
        """(...,) ratios of areas. camera: numbers; secant2: (...,) squared distances over squared depths."""
        step = np.arctan(np.sqrt(np.fmax(secant2 - 1.0, 0.0))) / STEP
        return np.asarray(self.table[camera, np.fmin(np.rint(step), STEPS - 1).astype(int)])


def stretch_by_angle(camera: Camera) -> Array:
    """:class:`Stretch` of one camera at `STEPS` angles: (STEPS,); beyond the picture as at its corners.

    The share of the picture that a ring of directions fills, over the share of all directions.
    """
    edges = np.maximum(np.arange(STEPS + 1) - 0.5, 0.0) * STEP
    rays = np.stack([np.sin(edges), np.zeros(STEPS + 1), np.cos(edges)], axis=1)
    image = project_local(camera, rays)[:, 0] - camera.matrix[0, 2]
    rings = np.diff(np.square(image / camera.matrix[0, 0])) / (-2 * np.diff(np.cos(edges)))
    beyond = ~((np.diff(image) > 0) & (image[:-1] < np.hypot(*camera.size) / 2))
    if beyond.any():
        first = max(int(beyond.argmax()), 1)
        rings[first:] = rings[first - 1]
    return np.asarray(rings)
