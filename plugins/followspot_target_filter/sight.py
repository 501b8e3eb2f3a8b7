"""How many cameras of a room have a place in their pictures."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot.room import Camera


class Sight:
    """The pictures of a room's cameras."""

    def __init__(self, cameras: Iterable[Camera]) -> None:
        self.views = Views(cameras)
        self.size = np.array([c.size for c in self.views.cameras], float).reshape(-1, 1, 2)

    def count(self, xyz: Array) -> Array:
        """How many cameras have each place in their pictures: (N, 3) m -> (N,)."""
        pixel = self.views.project_local(self.views.local(xyz))  # NaN behind a camera is in no picture
        return np.asarray(((pixel >= 0) & (pixel < self.size)).all(axis=2).sum(axis=0))
