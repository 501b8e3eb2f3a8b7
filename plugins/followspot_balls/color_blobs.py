"""Glowing balls in a colour camera, by hue, size and similarity (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.color_mask import Limits, Sought, in_picture, in_windows, packed
from followspot_balls.components import Components, above_local_peak, clipped, components, of_size
from followspot_balls.hue import BINS, bhattacharyya, hue_bin, membership, normalised
from followspot_balls.search import Regions, in_plane, search_regions
from followspot_balls.strip import window_border
from followspot_balls.votes import disc_centers

SMALL = 12.0
"""Area up to which a blob is never too large for its forecast, px: pixels are coarse."""


class Found(NamedTuple):
    """Blobs of some targets."""

    pixel: Array
    area: Array
    similarity: Array
    target: Array


NOTHING = Found(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0, int))


class ColorBlobs(Stage):
    """Find blobs of the targets' colours near the forecasts; in the whole image for lost targets."""

    per_camera = True

    class Params(StageParams):
        similarity: float = Field(
            0.8,
            ge=0,
            le=1,
            unit="1",
            description="least Bhattacharyya coefficient with the template; raising it rejects more "
            "projections, and balls on which projections of another colour fall",
        )
        saturation: int = Field(
            80,
            ge=0,
            le=255,
            unit="1",
            description="least saturation of a pixel that shows its hue; raising it ignores pale light",
        )
        value: int = Field(
            70,
            ge=1,
            le=255,
            unit="1",
            description="least brightness of a pixel; raising it ignores dim projections, and dim balls",
        )
        white: int = Field(
            245,
            ge=1,
            le=256,
            unit="1",
            description="brightness from which a pale pixel counts as an overexposed core; 256: none does",
        )
        hue_share: float = Field(
            0.02,
            gt=0,
            lt=1,
            unit="1",
            description="least part of the histogram that a hue must hold; raising it narrows the colour",
        )
        edge: float = Field(
            0.7,
            gt=0,
            lt=1,
            unit="1",
            description="edge of a blob over its brightest pixel; raising it shrinks blobs and parts them",
        )
        rim: float = Field(
            0.0,
            unit="px",
            description="how much wider than its outline a ball looks at the edge; raise it where balls are "
            "overexposed",
        )
        smallest: float = Field(
            0.3,
            gt=0,
            unit="1",
            description="smallest area over the template's; lowering it accepts balls that are mostly hidden",
        )
        largest: float = Field(
            1.5,
            gt=0,
            unit="1",
            description="largest area over the template's; raising it accepts balls merged with projections",
        )
        submerged: float = Field(
            1.8,
            gt=0,
            unit="1",
            description="largest area over the outline expected at the forecast; a ball that is part of more "
            "counts as hidden; raising it keeps biased blobs",
        )
        radius: float = Field(
            10.0,
            gt=0,
            unit="px",
            description="smallest search radius; raising it survives jumps, and costs time",
        )
        scale: float = Field(
            1.5,
            gt=0,
            unit="1",
            description="search radius over expected travel; raising it survives sharper turns",
        )

    params: Params

    def setup(self) -> None:
        name = self.camera.name
        targets = self.room.targets.values()
        self.sizes = np.array([t.radius for t in targets])
        self.histograms = np.array([t.hue_histogram.get(name, np.zeros(BINS)) for t in targets])
        self.histograms = self.histograms.reshape(-1, BINS)
        self.member = membership(self.histograms, self.params.hue_share)
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        self.tables = packed(self.member)
        self.numbers = np.arange(len(self.sizes))
        self.limits = Limits(self.params.saturation, self.params.value, self.params.white)
        self.area = np.ascontiguousarray((area * [self.params.smallest, self.params.largest]).T)

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        regions = search_regions(self.room, forecast, p.radius, p.scale)[self.camera.name]
        found = [NOTHING]
        if len(regions.near):
            sought = in_windows(frame.pixels, regions, self.tables, self.limits)
            found.append(self.measured(sought, regions))
        if regions.circles.lost.any():
            lost = regions.circles.lost.nonzero()[0]
            smallest = self.area[0, lost]
            found.append(self.measured(in_picture(frame.pixels, lost, self.member, self.limits, smallest)))
        blobs = found[-1] if len(found) < 3 else Found(*map(np.concatenate, zip(*found, strict=True)))
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, blobs.pixel),
            pixel=blobs.pixel,
            area=blobs.area,
            similarity=blobs.similarity,
            targets=blobs.target[:, None] == self.numbers,
        )

    def measured(self, sought: Sought, regions: Regions | None = None) -> Found:
        """Blobs of the targets that a strip is searched for.

        regions: where the parts are their windows.
        """
        p = self.params
        level, target = sought.level, sought.target
        blobs = components(above_local_peak(level, p.edge), level, sought.strip)
        owner = target.take(blobs.part)
        smallest, largest = self.area.take(owner, axis=1)
        keep = of_size(blobs.area, smallest, largest)
        histograms = component_histograms(blobs, sought.hue, sought.colored)
        similarity = bhattacharyya(histograms, self.histograms.take(owner, axis=0))
        keep &= similarity > p.similarity
        pixel = sought.strip.shift.take(blobs.part, axis=0)
        if regions is None:
            pixel = pixel + blobs.center
        else:
            circles, ball = regions.circles, regions.circles.ball.take(owner)
            keep &= blobs.area <= np.maximum(p.submerged * np.pi * ball * ball, SMALL)
            keep &= ~clipped(blobs, window_border(len(target), regions.side))
            pixel = pixel + disc_centers(level, blobs, np.where(keep, ball + p.rim, np.nan), p.edge)
            offset = in_plane(pixel - circles.center.take(owner, axis=0))
            keep &= np.abs(offset) <= circles.radius.take(owner)
        rows = keep.nonzero()[0]
        return Found(pixel.take(rows, axis=0), blobs.area.take(rows), similarity.take(rows), owner.take(rows))


def component_histograms(blobs: Components, hue: Array, colored: Array) -> Array:
    """Normalised hue histogram (eq. 1) of each component over its coloured pixels: (N, 16).

    hue: (H, W) u8 of the strip, full range; colored: (H, W) bool.
    """
    bins, counted = hue_bin(hue.take(blobs.pixels)), colored.take(blobs.pixels)
    counts = np.bincount(blobs.label * BINS + bins, counted, len(blobs.area) * BINS)
    return normalised(counts.reshape(-1, BINS))
