"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import above_local_peak, components, cut
from followspot_balls.search import search_circles


class IrBlobs(Stage):
    """Find bright blobs, near the forecasts or in the whole image while a target is lost; they bear no label."""

    per_camera = True

    class Params(StageParams):
        edge: float = Field(
            0.35,
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
            description="largest area over the template's; raising it accepts merged balls",
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
        self.gray = np.reshape([t.gray.get(name, (256.0, 0.0)) for t in targets], (-1, 2))
        area = np.reshape([t.area.get(name, (0.0, 0.0)) for t in targets], (-1, 2))
        self.area = area * [self.params.smallest, self.params.largest]
        self.margin = 2 + int(np.sqrt(4 / np.pi * area[:, 1].max(initial=1)))

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        circles = search_circles(self.camera, forecast, len(self.area), p.radius, p.scale)
        half = circles.radius + self.margin
        low, high = circles.center - half[:, None], circles.center + half[:, None]
        left, top, right, bottom = self.window(low, high, circles.lost, frame.pixels.shape)
        pixels = frame.pixels[top:bottom, left:right]
        low_gray, high_gray = self.gray[:, 0].min(initial=256), self.gray[:, 1].max(initial=0)
        tiles = cut(pixels, np.zeros((1, 2), int), *pixels.shape[:2])[..., 0]
        level = np.where((tiles >= low_gray) & (tiles <= high_gray), tiles, 0).astype(np.uint8)
        blobs = components(above_local_peak(level[0], p.edge)[None], level)
        pixel = blobs.center + [left, top]
        inside = circles.lost | ((pixel[:, None] >= low) & (pixel[:, None] <= high)).all(axis=2)
        area = blobs.area[:, None]
        targets = inside & (area >= self.area[:, 0]) & (area <= self.area[:, 1])
        keep = targets.any(axis=1)
        pixel = pixel[keep]
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel),
            pixel=pixel,
            area=blobs.area[keep].astype(float),
            similarity=np.ones(len(pixel)),
            targets=targets[keep],
        )

    def window(
        self, low: Array, high: Array, lost: Array, shape: tuple[int, ...]
    ) -> tuple[int, int, int, int]:
        """The rectangle around all search regions, within the picture: left, top, right, bottom."""
        height, width = shape[:2]
        if lost.any():
            return 0, 0, width, height
        seen = ~np.isnan(low[:, 0])
        if not seen.any():
            return 0, 0, 0, 0
        left, top = np.clip(low[seen].min(axis=0), 0, [width, height]).astype(int).tolist()
        right, bottom = np.clip(high[seen].max(axis=0) + 2, 0, [width, height]).astype(int).tolist()
        return left, top, right, bottom
