"""Blobs of colour cameras at the images of positions: which targets the positions may be by their colour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array, Room
from followspot.tracking import Blobs
from followspot_balls.scene.targets import target_radii
from followspot_balls.single_view.position import projections

NEAREST = 1e-9
"""Smallest depth of a position that is divided by, m."""


class ColorViews:
    """The colour cameras of a room."""

    def __init__(self, room: Room) -> None:
        color = {name: camera for name, camera in room.cameras.items() if camera.kind == "color"}
        self.number = {name: number for number, name in enumerate(color)}
        self.P = np.array([camera.projection for camera in color.values()]).reshape(-1, 3, 4)
        self.focal = np.array([camera.matrix[0, 0] for camera in color.values()])
        self.radii = target_radii(room)

    def shown(self, xyz: Array, blobs: Sequence[Blobs], scale: float = 1.0) -> Array:
        """Which targets blobs of colour cameras show at each position (N, 3) m: (N, T) bool.

        scale: largest distance between a blob and the image of a position that it shows, over the ball's
        radius.
        """
        found = np.zeros((len(xyz), len(self.radii)), bool)
        for one in blobs:
            number = self.number.get(one.camera)
            if number is None or not len(one.xy):
                continue
            P = self.P[number]
            depth = np.maximum(xyz @ P[2, :3] + P[2, 3], NEAREST)
            reach = scale * self.focal[number] * self.radii / depth[:, None]
            apart = np.hypot(*(projections(P[None], xyz[None])[0][0][:, None] - one.xy).transpose(2, 0, 1))
            found |= ((apart[..., None] <= reach[:, None]) & one.targets).any(axis=1)
        return found
