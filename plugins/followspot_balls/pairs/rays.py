"""The rays of pairs of blobs, and the points where they meet (Jin & Qian 2008, section 3.5)."""

from __future__ import annotations

import numpy as np

from followspot.geometry import back_projection, triangulate_pairs
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import Pairs


class PairRays:
    """The cameras of a room, from which rays lead through blobs."""

    def __init__(self, room: Room) -> None:
        cameras = room.cameras.values()
        self.centers = np.array([c.center for c in cameras]).reshape(-1, 3)
        """(C, 3) m."""
        self.back = np.array([back_projection(c) for c in cameras]).reshape(-1, 3, 3)

    def points(self, pairs: Pairs) -> Array:
        """The points nearest to both rays of N pairs: (N, 3) m, NaN for rays that do not meet."""
        back, xy = self.back.take(pairs.view, axis=0), pairs.xy[..., None]
        rays = back[..., 0] * xy[:, :, 0] + back[..., 1] * xy[:, :, 1] + back[..., 2]
        rays /= np.sqrt(np.vecdot(rays, rays))[..., None]
        return triangulate_pairs(self.centers.take(pairs.view, axis=0), rays)
