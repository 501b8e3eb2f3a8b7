"""The vertical axis of a standing body in a picture, and how far away a row of the floor below it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_persons.body.standing import WAIST, rise
from followspot_persons.body.view import HEIGHT

BEFORE_AXIS = 0.18
"""Distance of the nearer foot's edge from the axis of the body, towards the camera, m."""


@dataclass(frozen=True, eq=False)
class Axis:
    """Pixels of the head's top, of the waist and of the point on the floor below, (2,) each."""

    head: Array
    waist: Array
    foot: Array

    @classmethod
    def of(cls, camera: Camera, pose: Array) -> Axis | None:
        """The axis of a pose (6,); None if the camera does not see it upright."""
        rows = np.array([pose[HEIGHT], WAIST * pose[HEIGHT], 0.0])
        axis = cls(*project(camera, np.column_stack([np.tile(pose[:2], (3, 1)), rows])))
        seen = np.isfinite([axis.head, axis.waist, axis.foot]).all()
        return axis if seen and axis.head[1] < axis.waist[1] < axis.foot[1] else None

    @property
    def tall(self) -> float:
        """Height of the upper body, px."""
        return float(self.waist[1] - self.head[1])

    def column(self, row: Array) -> Array:
        """Columns at these rows, px."""
        (x0, y0), (x1, y1) = self.head, self.foot
        return np.asarray(x0 + (row - y0) * (x1 - x0) / (y1 - y0))

    def beside(self, rows: Array, half: int) -> Array:
        """Columns up to so many beside the axis at these rows (R,), (R, 2 half + 1) px."""
        return np.rint(self.column(rows)).astype(int)[:, None] + np.arange(-half, half + 1)


def distance_on_floor(camera: Camera, axis: Axis, low: int) -> float | None:
    """Horizontal distance of a person whose lowest row in the picture is `low`, m; None if the picture ends
    there, or if it shows no floor there.
    """
    if low >= camera.size[1] - 2:
        return None
    down = float(rise(camera, axis.column(np.array([low])), np.array([low + 0.5]))[0])
    return float(-camera.center[2] / down) + BEFORE_AXIS if down < 0 else None
