"""Search regions in the views (Jin & Qian 2008, section 3.3, eq. 3)."""

from __future__ import annotations

from followspot import Latest, Stage
from followspot.tracking import Blobs, Forecast
from followspot_balls.detection.detector import SearchParams
from followspot_balls.detection.search_circles import search_circles, within


class SearchGate(Stage):
    """Reject blobs outside the circle where their target is expected; a blob may serve several."""

    class Params(SearchParams):
        """Radius of the circle."""

    params: Params

    def process(self, blobs: Blobs, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        circles = search_circles(
            self.room, blobs.camera, forecast, p.minimum_search_radius, p.search_radius_scale
        )
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
