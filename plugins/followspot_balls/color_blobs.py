"""Glowing balls in a colour camera, by hue, size and similarity (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import Components, above_local_peak, components, cut
from followspot_balls.hue import BINS, bhattacharyya, hue_bin, membership, normalised
from followspot_balls.search import search_circles


class ColorBlobs(Stage):
    """Find blobs of the targets' colours, near the forecasts or in the whole image while a target is lost."""

    per_camera = True

    class Params(StageParams):
        similarity: float = Field(
            0.8,
            ge=0,
            le=1,
            unit="1",
            description="least Bhattacharyya coefficient with the template; raising it rejects more projections,"
            " and balls that projections of another colour hit",
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
            description="brightness from which a pale pixel counts as a saturated core; 256: none does",
        )
        hue_share: float = Field(
            0.02,
            gt=0,
            lt=1,
            unit="1",
            description="least part of the histogram that a hue must hold; raising it narrows the colour",
        )
        edge: float = Field(
            0.5,
            gt=0,
            lt=1,
            unit="1",
            description="edge of a blob over its brightest pixel; raising it shrinks blobs and parts them",
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
        radius: float = Field(
            10.0,
            gt=0,
            unit="px",
            description="smallest search radius; raising it survives jumps, and costs time",
        )
        scale: float = Field(1.5, gt=0, unit="1", description="search radius over expected travel")

    params: Params

    def setup(self) -> None:
        name = self.camera.name
        targets = self.room.targets.values()
        histograms = [t.hue_histogram.get(name, np.zeros(BINS)) for t in targets]
        self.histograms = np.reshape(np.asarray(histograms, float), (-1, BINS))
        self.member = membership(self.histograms, self.params.hue_share)
        area = np.reshape([t.area.get(name, (0.0, 0.0)) for t in targets], (-1, 2))
        self.area = area * [self.params.smallest, self.params.largest]
        self.margin = 2 + int(np.sqrt(4 / np.pi * area[:, 1].max(initial=1)))

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        circles = search_circles(self.camera, forecast, len(self.member), p.radius, p.scale)
        near = np.flatnonzero(~np.isnan(circles.center[:, 0]))
        half = int(circles.radius[near].max(initial=0)) + self.margin
        corners = np.rint(np.nan_to_num(circles.center[near])).astype(int) - half
        found = [self.search(frame.pixels, near, corners, (2 * half + 1, 2 * half + 1))]
        lost = np.flatnonzero(circles.lost)
        if len(lost):
            height, width = frame.pixels.shape[:2]
            found.append(self.search(frame.pixels, lost, np.zeros((1, 2), int), (height, width)))
        pixel, area, similarity, target = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel),
            pixel=pixel,
            area=area,
            similarity=similarity,
            targets=np.eye(len(self.member), dtype=bool)[target],
        )

    def search(
        self, pixels: Array, target: Array, corners: Array, size: tuple[int, int]
    ) -> tuple[Array, Array, Array, Array]:
        """Blobs of each target in its window; one window serves all targets where there is one corner."""
        if len(target) == 0:
            return np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0, int)
        p = self.params
        hsv = hsv_tiles(cut(pixels, corners, *size))
        colored, mask, value = color_mask(hsv, self.member[target], p.saturation, p.value, p.white, p.edge)
        blobs = components(mask, value)
        bins = hue_bin(np.broadcast_to(hsv[..., 0], mask.shape).ravel()[blobs.index])
        histograms = component_histograms(blobs, bins, colored.ravel()[blobs.index])
        owner = target[blobs.tile]
        similarity = bhattacharyya(histograms, self.histograms[owner])
        smallest, largest = self.area[owner].T
        keep = (similarity > p.similarity) & (blobs.area >= smallest) & (blobs.area <= largest)
        corner = np.broadcast_to(corners, (len(target), 2))[blobs.tile]
        return (blobs.center + corner)[keep], blobs.area[keep].astype(float), similarity[keep], owner[keep]


def hsv_tiles(tiles: Array) -> Array:
    """Hue (full range), saturation and value of a stack of BGR pictures, (N, H, W, 3) u8."""
    return cv2.cvtColor(tiles.reshape(-1, *tiles.shape[2:]), cv2.COLOR_BGR2HSV_FULL).reshape(tiles.shape)


def color_mask(
    hsv: Array, member: Array, saturation: int, value: int, white: int, edge: float
) -> tuple[Array, Array, Array]:
    """Pixels of each target: of its hues, or white cores, and above `edge` times the local peak.

    hsv: (N or 1, H, W, 3) u8; member: (N, 256) bool. Returns the pixels that show the hue, the mask and
    the value above the edge, each (N, H, W).
    """
    hue, s, v = hsv[..., 0], hsv[..., 1], hsv[..., 2]
    bright = v >= value
    vivid = bright & (s >= saturation)
    core = (v >= white) & ~vivid
    colored = np.stack(
        [table[h] for table, h in zip(member, np.broadcast_to(hue, (len(member), *hue.shape[1:])))]
    )
    colored &= vivid
    sought = colored | core
    level = np.where(sought, v, 0).astype(np.uint8)
    tall = level.reshape(-1, level.shape[2])
    mask = above_local_peak(tall, edge).reshape(level.shape)
    return colored, mask, level


def component_histograms(blobs: Components, bins: Array, colored: Array) -> Array:
    """Normalised hue histogram of each component over its coloured pixels: (N, 16)."""
    cell = blobs.label * BINS + bins
    return normalised(np.bincount(cell, colored, len(blobs.area) * BINS).reshape(-1, BINS))
