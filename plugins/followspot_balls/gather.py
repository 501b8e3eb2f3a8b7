"""Candidates of several stages in one message."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Joined, Stage
from followspot.tracking import Candidates


class Gather(Stage):
    """Put the candidates of several depth cameras, and of pairs of other cameras, into one message."""

    def setup(self) -> None:
        self.cameras = tuple(self.room.cameras)
        targets = np.zeros((0, len(self.room.targets)), bool)
        self.nothing = replace(Candidates.empty(), cameras=self.cameras, targets=targets)

    def process(self, candidates: Joined[Candidates]) -> Candidates:
        parts = [self.numbered(part) for part in candidates if len(part.xyz)]
        if len(parts) < 2:
            return parts[0] if parts else self.nothing
        columns = {name: np.concatenate([getattr(p, name) for p in parts]) for name in Candidates.array_names}
        return Candidates(cameras=self.cameras, **columns)

    def numbered(self, part: Candidates) -> Candidates:
        """The candidates with views that are numbers of the room's cameras. Raises ValueError."""
        if part.cameras == self.cameras:
            return part
        number = np.array([self.cameras.index(name) for name in part.cameras], np.int32)
        return replace(part, cameras=self.cameras, view=number[part.view])
