"""Glowing balls in a colour camera, by hue, size and similarity (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple, Self

import numpy as np

from followspot import Array, Camera, Field, Latest, Mistake, Room, Stage
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.detection.color_mask import Limits, Sought, in_pictures, in_windows
from followspot_balls.detection.components import Components, above_local_peak, clipped, components, of_size
from followspot_balls.detection.detector import (
    DetectionParams,
    Detections,
    blobs_by_view,
    of_one_color,
    without_template,
)
from followspot_balls.detection.hough import disc_centers, own_area
from followspot_balls.detection.hue import BINS, bhattacharyya, hue_bits, normalised
from followspot_balls.detection.rival_colors import best_fitting, rivals
from followspot_balls.detection.search_circles import Circles, Regions, search_regions
from followspot_balls.detection.strip import Windows, abreast, row_and_column

SMALL = 12.0
"""Area up to which a blob is never too large for its forecast, px: pixels are coarse."""


class Found(NamedTuple):
    """Blobs of some targets."""

    pixel: Array
    area: Array
    similarity: Array
    owner: Array
    """(N,) row of the target among those of all views."""


NOTHING = Found(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0, int))


class Templates(NamedTuple):
    """Templates of the targets in some views: a row for each target of each view in turn."""

    histograms: Array
    """(rows, 16) hue, normalised."""
    hues: Array
    """(rows,) u16, bits of the hues of the target."""
    area: Array
    """(rows, 2) smallest and largest, px."""
    rival: Array
    """(rows, T) bool, the targets whose blobs are taken for those of the target, and the other way round."""


class ColorBlobs(Stage):
    """Find blobs of the targets' colours near the forecasts; in the whole image for lost targets.

    A blob that may belong to two targets of similar hues belongs to the one whose template it fits best.
    """

    per_camera = True
    advice = (
        "learn the templates in this light (`followspot calibrate targets`), or lower similarity, "
        "minimum_saturation and minimum_brightness"
    )

    class Params(DetectionParams):
        similarity: float = Field(
            0.8,
            ge=0,
            le=1,
            unit="1",
            description="smallest Bhattacharyya coefficient with the template; raising it rejects more "
            "projections, and balls lit by other colours",
        )
        minimum_saturation: int = Field(
            80,
            ge=0,
            le=255,
            unit="grey levels",
            description="smallest saturation of a coloured pixel; raising it ignores pale light",
        )
        minimum_brightness: int = Field(
            70,
            ge=1,
            le=255,
            unit="grey levels",
            description="smallest brightness of a pixel; raising it ignores dim balls",
        )
        overexposed_brightness: int = Field(
            245,
            ge=1,
            le=256,
            unit="grey levels",
            description="brightness of an overexposed core; 256: none; lowering it accepts more white light",
        )
        minimum_hue_share: float = Field(
            0.02,
            gt=0,
            lt=1,
            unit="1",
            description="smallest histogram share of a target's hue; raising it narrows the colour",
        )
        edge_level: float = Field(
            0.7,
            gt=0,
            lt=1,
            unit="1",
            description="brightness of a blob's edge over its peak; raising it shrinks blobs and separates "
            "them",
        )
        radius_offset: float = Field(
            0.0,
            unit="px",
            description="measured minus true radius of a ball; raising it suits overexposed balls",
        )
        maximum_expected_area: float = Field(
            1.8,
            gt=0,
            unit="1",
            description="largest blob area over the area expected at the forecast; larger blobs are kept "
            "only if a rim tells the ball from other light; raising it keeps biased blobs",
        )

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


def blobs_of(
    pictures: Sequence[Array], regions: Regions, templates: Templates, p: ColorBlobs.Params
) -> Found:
    """Blobs of targets in their windows, for all views at once; lost targets are sought in whole pictures."""
    limits = Limits(p.minimum_saturation, p.minimum_brightness, p.overexposed_brightness)
    count = len(regions.circles.lost) // len(pictures)
    found = [NOTHING]
    if len(regions.near):
        shown = [pictures[number] for number in (regions.near // count).tolist()]
        windows = abreast(regions.corners, regions.sides)
        sought = in_windows(shown, windows, regions.near, templates.hues, limits)
        found.append(measured(sought, templates, p, count, (regions.circles, windows)))
    lost = regions.circles.lost.reshape(len(pictures), count)
    target = np.asarray(lost.any(axis=0)).nonzero()[0]
    if len(target):
        rows = np.arange(len(pictures))[:, None] * count + target
        bits = templates.hues.take(rows) * lost.take(target, axis=1)
        owner = rows.reshape(-1)
        smallest = templates.area[:, 0].take(owner)
        sought = in_pictures(pictures, owner, bits, limits, smallest)
        found.append(measured(sought, templates, p, count))
    blobs = found[-1] if len(found) < 3 else Found(*map(np.concatenate, zip(*found, strict=True)))
    if not np.count_nonzero(templates.rival):
        return blobs
    return Found(*(column[best_fitting(*blobs, templates.rival)] for column in blobs))


def joint_templates(stages: tuple[ColorBlobs, ...]) -> Templates:
    """Templates of the views of several stages."""
    return Templates(*map(np.concatenate, zip(*(stage.templates for stage in stages), strict=True)))


def measured(
    sought: Sought,
    templates: Templates,
    p: ColorBlobs.Params,
    count: int,
    near: tuple[Circles, Windows] | None = None,
) -> Found:
    """Blobs of the targets in the parts of a strip.

    count: targets of each view; near: search regions, if the parts are their windows.
    """
    level, strip = sought.level, sought.strip
    blobs = components(above_local_peak(level, p.edge_level), level, strip)
    owner = sought.owner.take(blobs.part)
    smallest, largest = templates.area.take(owner, axis=0).T
    area = blobs.area
    keep = of_size(area, smallest, largest if near is None else np.inf, owner // max(count, 1))
    histograms = component_histograms(blobs, sought.hue)
    similarity = bhattacharyya(histograms, templates.histograms.take(owner, axis=0))
    keep &= similarity > p.similarity
    pixel = blobs.center
    if near is not None:
        circles, windows = near
        ball = circles.ball.take(owner)
        keep &= ~clipped(blobs, strip, windows)
        radius = np.where(keep, ball + p.radius_offset, np.nan)
        expected = circles.center.take(owner, axis=0)
        beside = circles.beside.take(owner)
        pixel, rim = disc_centers(level, strip, blobs, radius, p.edge_level, expected, beside)
        bound = np.minimum(largest, np.maximum(p.maximum_expected_area * np.pi * ball * ball, SMALL))
        area = own_area(area, bound, radius, rim)
        keep &= area <= bound
        right, down = (pixel - expected).T
        keep &= np.hypot(right, down) <= circles.radius.take(owner)
    rows = keep.nonzero()[0]
    return Found(pixel.take(rows, axis=0), area.take(rows), similarity.take(rows), owner.take(rows))


def component_histograms(blobs: Components, hue: Array) -> Array:
    """Normalised hue histogram (eq. 1) of each component over its coloured pixels: (N, 16).

    hue: (H, W) u8 of the strip, bins; `BINS` in an overexposed core.
    """
    count = len(blobs.area)
    cells = blobs.label * (BINS + 1) + hue.take(blobs.pixels)
    counts = np.bincount(cells, minlength=count * (BINS + 1)).reshape(count, BINS + 1)
    return normalised(counts[:, :BINS])
