"""Finds pairs that show a ball that lies on a plane; the homography test alone takes them for projections."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, Forecast
from followspot_balls.measurement.outline import unit_outline
from followspot_balls.measurement.points import point_images
from followspot_balls.scene.bounding_planes import nearest_planes
from followspot_balls.scene.targets import target_radii


class LyingTargets:
    """The tracked targets of a room that lie on its planes. clearance: m, of a ball that lies on one."""

    def __init__(self, room: Room, clearance: float) -> None:
        self.clearance = clearance
        cameras = list(room.cameras.values())
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.centers = np.array([c.center for c in cameras]).reshape(-1, 1, 3)
        self.planes = np.array(list(room.planes.values())).reshape(-1, 4)
        self.radius = target_radii(room)
        self.outline = unit_outline(room)[:, None]

    def shown(self, ends: Array, cameras: Array, targets: Array, forecast: Forecast) -> Array:
        """Which pairs lie in both images of a target that is forecast to lie on a plane: (M,) bool.

        ends: (M, 2, 2) px, the two blobs; cameras: (M, 2) numbers; targets: (M, T) bool, which each may be.
        """
        lying = ((forecast.state != LOST) & self.touching(forecast.xyz)).nonzero()[0]
        if not len(lying):
            return np.zeros(len(ends), bool)
        place = forecast.xyz[lying]
        pixel = point_images(self.P, place).xy.swapaxes(0, 1)
        away = place - self.centers
        reach2 = self.outline / np.pi * self.radius[lying] ** 2 / np.vecdot(away, away)
        off = ends[:, :, None] - pixel[cameras]
        inside = np.vecdot(off, off) <= reach2[cameras]
        return np.asarray((inside.all(axis=1) & targets[:, lying]).any(axis=1))

    def touching(self, place: Array) -> Array:
        """Whether balls there touch a plane: (T, 3) m -> (T,) bool."""
        if not len(self.planes):
            return np.zeros(len(place), bool)
        return np.asarray(np.abs(nearest_planes(self.planes, place, self.radius)[1]) <= self.clearance)
