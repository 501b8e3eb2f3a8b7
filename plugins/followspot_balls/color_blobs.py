"""Glowing balls in a colour camera, by hue, size and similarity (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.color_mask import hsv_tiles, target_level
from followspot_balls.components import Components, above_local_peak, components, cut
from followspot_balls.hue import BINS, bhattacharyya, hue_bin, membership, normalised
from followspot_balls.search import in_picture, search_circles, windows, within
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
        self.area = area * [self.params.smallest, self.params.largest]

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        circles = search_circles(self.camera, forecast, self.sizes, p.radius, p.scale)
        near, lost = in_picture(circles, self.camera.size), np.flatnonzero(circles.lost)
        found = [NOTHING]
        if len(near):
            corners, side = windows(circles, near, self.camera.size)
            found.append(
                self.search(cut(frame.pixels, corners, side, side), near, corners, circles.ball[near])
            )
        if len(lost):
            corners = np.zeros((len(lost), 2), int)
            tiles = cut(frame.pixels, np.zeros((1, 2), int), *frame.pixels.shape[:2])
            found.append(self.search(tiles, lost, corners, None))
        blobs = Found(*map(np.concatenate, zip(*found, strict=True)))
        targets = within(circles, blobs.pixel) & (blobs.target[:, None] == np.arange(len(self.sizes)))
        keep = targets.any(axis=1)
        pixel = blobs.pixel[keep]
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel),
            pixel=pixel,
            area=blobs.area[keep],
            similarity=blobs.similarity[keep],
            targets=targets[keep],
        )

    def search(self, tiles: Array, target: Array, corners: Array, ball: Array | None) -> Found:
        """Blobs of each target in its tile, or in the one tile for all.

        tiles: (M or 1, h, w, 3) BGR; target: (M,); corners: (M, 2) of the tiles in the picture, px;
        ball: (M,) radius, px, where the tiles are search regions.
        """
        p = self.params
        hsv = hsv_tiles(tiles)
        colored, level = target_level(hsv, self.member[target], p.saturation, p.value, p.white)
        blobs = components(above_local_peak(level, p.edge), level, self.area[target])
        hue = np.broadcast_to(hsv.hue, level.shape).reshape(-1)[blobs.pixels]
        histograms = component_histograms(blobs, hue_bin(hue), colored.reshape(-1)[blobs.pixels])
        owner = target[blobs.tile]
        similarity = bhattacharyya(histograms, self.histograms[owner])
        keep = similarity > p.similarity
        center = blobs.center
        if ball is not None:
            outline = np.pi * np.square(ball[blobs.tile])
            keep &= ~blobs.clipped & (blobs.area <= np.maximum(p.submerged * outline, SMALL))
            center = disc_centers(level, blobs, ball[blobs.tile] + p.rim, p.edge)
        pixel = center + corners[blobs.tile]
        return Found(pixel[keep], blobs.area[keep], similarity[keep], owner[keep])


def component_histograms(blobs: Components, bins: Array, colored: Array) -> Array:
    """Normalised hue histogram (eq. 1) of each component over its coloured pixels: (N, 16)."""
    counts = np.bincount(blobs.label * BINS + bins, colored, len(blobs.area) * BINS)
    return normalised(counts.reshape(-1, BINS))
