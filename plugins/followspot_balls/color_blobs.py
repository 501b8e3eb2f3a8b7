"""Glowing balls in a colour camera, by hue, size and similarity (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Self

import numpy as np

from followspot import Camera, Latest, Mistake, Room, Stage
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.detection.color_params import ColorParams
from followspot_balls.detection.color_search import Templates, blobs_of
from followspot_balls.detection.detector import Detections, blobs_by_view, of_one_color, without_template
from followspot_balls.detection.hue import BINS, hue_bits
from followspot_balls.detection.rival_colors import rivals
from followspot_balls.detection.search_circles import search_regions
from followspot_balls.detection.strip import row_and_column


class ColorBlobs(Stage):
    """Find blobs of the targets' colours near the forecasts; in the whole image for lost targets.

    A blob that may belong to two targets of similar hues belongs to the one whose template it fits best.
    """

    per_camera = True
    advice = (
        "learn the templates in this light (`followspot calibrate targets`), or lower similarity, "
        "minimum_saturation and minimum_brightness"
    )

    class Params(ColorParams):
        """Which pixels are coloured, which blobs are a ball, and how far from a forecast they are sought."""

    params: Params

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn about targets without a template, and about those of one colour."""
        yield from without_template(room, cameras, "colour", lambda target: target.hue_histogram)
        yield from of_one_color(room, cameras)

    def setup(self) -> None:
        name, p = self.camera.name, self.params
        targets = self.room.targets.values()
        histograms = np.array([t.hue_histogram.get(name, np.zeros(BINS)) for t in targets]).reshape(-1, BINS)
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        hues = hue_bits(histograms, p.minimum_hue_share)
        rival = rivals(histograms, hues, p.similarity, p.minimum_area)
        self.templates = Templates(histograms, hues, area * [p.minimum_area, p.maximum_area], rival)
        self.joint: tuple[tuple[ColorBlobs, ...], Templates] = (self,), self.templates

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        return self.process_together([self], [(frame, forecast)])[0]

    @classmethod
    def process_together(
        cls, stages: Sequence[Self], inputs: Sequence[tuple[Frame, Forecast | None]]
    ) -> list[Blobs]:
        p, room = stages[0].params, stages[0].room
        cameras, pictures = [s.camera for s in stages], [frame.pixels for frame, _ in inputs]
        names, forecasts = [c.name for c in cameras], [f for _, f in inputs]
        regions = search_regions(room, names, forecasts, p.minimum_search_radius, p.search_radius_scale)
        found = blobs_of(pictures, regions, stages[0].templates_with(tuple(stages)), p)
        count = len(room.targets)
        view, target = row_and_column(found.owner, max(count, 1))
        targets = target[:, None] == np.arange(count)
        detections = Detections(found.pixel, found.area, found.similarity, targets)
        return blobs_by_view(cameras, view, detections, np.arange(len(view)))

    def templates_with(self, stages: tuple[ColorBlobs, ...]) -> Templates:
        """Templates of the views of several stages, which are the same at most firings.

        The stage holds them: a cache of the module would hold the stages, and with them runs that have ended.
        """
        if self.joint[0] != stages:
            self.joint = stages, joint_templates(stages)
        return self.joint[1]


def joint_templates(stages: tuple[ColorBlobs, ...]) -> Templates:
    """Templates of the views of several stages."""
    return Templates(*map(np.concatenate, zip(*(stage.templates for stage in stages), strict=True)))
