"""Stage `sim.marker_truth`: where the markers of `sim.marker_camera` are."""

from __future__ import annotations

import numpy as np

from followspot import Array, Source
from followspot.geometry import project
from followspot.tracking import Truth
from followspot_sim.marker_camera import MarkerSimParams, marker_pose
from followspot_sim.performance import Performance

INSIDE = 12.0
"""Distance from the border of the picture at which a marker is seen, px."""


class MarkerTruth(Performance):
    """Give the middle of each marker; marker k is target k of the room.

    The parameters must equal those of the cameras.
    A marker is trackable if it faces a camera that has it in its picture; other markers may hide it.
    """

    class Params(MarkerSimParams):
        """The markers."""

    params: Params

    def process(self) -> Source[Truth]:
        """Places of the markers that are targets, frame k at k / fps seconds."""
        names = tuple(self.room.targets)[: self.params.markers]
        for frame in self.frames():
            poses = [marker_pose(k, self.params.markers, frame / self.params.fps) for k in range(len(names))]
            shown = np.array([sum(self.shown(*pose)) for pose in poses], int)
            xyz = np.array([middle for _, middle in poses]).reshape(-1, 3)
            yield self.at(frame, Truth(names, xyz, shown == 0, shown >= 1, shown >= 2))

    def shown(self, rotation: Array, middle: Array) -> list[bool]:
        """Which cameras see the face of a marker."""
        found = []
        for camera in self.room.cameras.values():
            to_camera = camera.center - middle
            ahead = rotation[:, 2] @ to_camera > 0.2 * np.linalg.norm(to_camera)
            pixel, size = project(camera, middle[None])[0], np.array(camera.size)
            found.append(bool(ahead and (pixel > INSIDE).all() and (pixel < size - INSIDE).all()))
        return found
