"""Search regions in the views (Jin & Qian 2008, section 3.3, eq. 3)."""

from __future__ import annotations

import dataclasses

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.tracking import Blobs, Forecast
from followspot_balls.search import Circles, search_circles


class SearchGate(Stage):
    """Reject blobs outside the circle where their target is expected; a blob may serve several."""

    class Params(StageParams):
        radius: float = Field(
            10.0,
            gt=0,
            unit="px",
            description="smallest search radius; raising it survives jumps, and lets more in",
        )
        scale: float = Field(1.5, gt=0, unit="1", description="search radius over expected travel")

    params: Params

    def process(self, blobs: Blobs, forecast: Latest[Forecast] = None) -> Blobs:
        camera = self.room.cameras[blobs.camera]
        count = len(self.room.targets)
        circles = search_circles(camera, forecast, count, self.params.radius, self.params.scale)
        targets = blobs.targets & within(circles, blobs.pixel)
        keep = targets.any(axis=1)
        return dataclasses.replace(
            blobs,
            xy=blobs.xy[keep],
            pixel=blobs.pixel[keep],
            area=blobs.area[keep],
            similarity=blobs.similarity[keep],
            targets=targets[keep],
        )


def within(circles: Circles, pixel: Array) -> Array:
    """Which points lie in which target's search region: (N, 2) px -> (N, T) bool; in a lost one's all do."""
    offset = pixel[:, None] - circles.center
    return np.asarray(circles.lost | (np.hypot(offset[..., 0], offset[..., 1]) <= circles.radius))
