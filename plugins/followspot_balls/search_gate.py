"""Search regions in the views (Jin & Qian 2008, section 3.3, eq. 3)."""

from __future__ import annotations

from followspot import Field, Latest, Stage, StageParams
from followspot.tracking import Blobs, Forecast
from followspot_balls.search import search_circles, within


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
        circles = search_circles(self.room, blobs.camera, forecast, self.params.radius, self.params.scale)
        targets = blobs.targets & within(circles, blobs.pixel)
        keep = targets.any(axis=1)
        return Blobs(
            camera=blobs.camera,
            xy=blobs.xy[keep],
            pixel=blobs.pixel[keep],
            area=blobs.area[keep],
            similarity=blobs.similarity[keep],
            targets=targets[keep],
        )
