"""A tracker that never finds a target, so that benchmarks can time the search for all of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.stage import Stage
from followspot.tracking import LOST, Forecast, Positions, Tracks


@dataclass(frozen=True)
class Found:
    """A tracker's outputs."""

    tracks: Tracks
    forecast: Forecast


class NeverFound(Stage):
    """A tracker that believes nothing, so that all targets are sought in whole images for ever."""

    def process(self, positions: Positions) -> Found:
        """No track, and a forecast in which all targets are lost."""
        count = len(self.room.targets)
        nowhere = np.zeros((count, 3))
        lost = Forecast(
            period=0.0,
            state=np.full(count, LOST, np.uint8),
            xyz=nowhere,
            velocity=nowhere,
            covariance=np.zeros((count, 3, 3)),
            last=nowhere,
            before=nowhere,
        )
        return Found(Tracks.empty(), lost)
