"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import above_local_peak, clipped, components, of_size
from followspot_balls.search import Circles, Regions, distances, search_regions, within
from followspot_balls.strip import Strip, clusters, cut, scattered, window_border, window_strip
from followspot_balls.votes import disc_centers

SAME = 0.5
"""Distance below which blobs of two windows are one, px."""


class IrBlobs(Stage):
    """Find bright blobs near the forecasts, in the whole image for lost targets; they bear no label."""

    per_camera = True

    class Params(StageParams):
        edge: float = Field(
            0.45,
            gt=0,
            lt=1,
            unit="1",
            description="edge of a blob over its brightest pixel; raising it shrinks blobs and parts them",
        )
        rim: float = Field(
            -0.5,
            unit="px",
            description="how much wider than its outline a ball looks at the edge; patches reflect less "
            "towards the rim, so it is negative",
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
        gray = np.array([t.gray.get(name, (256.0, 0.0)) for t in targets]).reshape(-1, 2)
        self.darkest = float(np.ceil(gray[:, 0].min(initial=256)))
        self.brightest = float(np.floor(gray[:, 1].max(initial=0)))
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        self.area = area * [self.params.smallest, self.params.largest]
        self.sought = self.area[:, 0].min(initial=1e9), self.area[:, 1].max(initial=0)

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        regions = search_regions(self.room, forecast, p.radius, p.scale)[self.camera.name]
        pixel, area = self.search(frame.pixels, regions)
        fits = (area[:, None] >= self.area[:, 0]) & (area[:, None] <= self.area[:, 1])
        targets = within(regions.circles, pixel) & fits
        rows = np.flatnonzero(targets.any(axis=1))
        pixel = pixel.take(rows, axis=0)
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel),
            pixel=pixel,
            area=area.take(rows),
            similarity=np.ones(len(rows)),
            targets=targets.take(rows, axis=0),
        )

    def search(self, pixels: Array, regions: Regions) -> tuple[Array, Array]:
        """Centres (N, 2) px and areas (N,) px of bright blobs, each once, in the windows or the picture."""
        if regions.circles.lost.any():
            return self.measured(*self.in_picture(pixels), regions.circles)
        if not len(regions.near):
            return np.empty((0, 2)), np.empty(0)
        level = self.level(cut(pixels, regions.corners, regions.side)[..., 0])
        strip = window_strip(regions.corners, regions.side)
        return self.measured(level, strip, regions.circles, regions.side)

    def in_picture(self, pixels: Array) -> tuple[Array, Strip]:
        """Bright pixels of the whole picture, gathered into a strip."""
        level = self.level(pixels[..., 0])
        index = np.flatnonzero(level)
        y, x = np.divmod(index, level.shape[1])
        found = clusters(np.zeros(len(index), int), y, x, (1, *level.shape), np.array(self.sought[:1]))
        return scattered(found, level.reshape(-1).take(index.take(found.entry))), found.strip

    def level(self, gray: Array) -> Array:
        """Grey levels in the range, 0 elsewhere."""
        return np.asarray(cv2.inRange(gray, self.darkest, self.brightest) & gray)

    def measured(self, level: Array, strip: Strip, circles: Circles, side: int = 0) -> tuple[Array, Array]:
        """Centres and areas of the bright blobs of a strip; side: of its windows, if such are its parts."""
        blobs = components(above_local_peak(level, self.params.edge), level, strip)
        shift = strip.shift.take(blobs.part, axis=0)
        keep = of_size(blobs.area, *self.sought)
        if side:
            keep &= ~clipped(blobs, window_border(len(strip.shift), side))
        rows = keep.nonzero()[0]
        radius = nearest_radius(circles, blobs.center + shift)
        rim = np.where(keep, radius + self.params.rim, np.nan)
        center = disc_centers(level, blobs, rim, self.params.edge) + shift
        return distinct(center.take(rows, axis=0), blobs.area.take(rows))


def nearest_radius(circles: Circles, pixel: Array) -> Array:
    """Radius of the ball whose forecast is nearest to each blob: (N, 2) px -> (N,) px, NaN without one."""
    if not circles.ball.size:
        return np.full(len(pixel), np.nan)
    distance = distances(pixel, circles.center)
    distance = np.where(distance <= circles.radius + circles.ball, distance, np.inf)
    nearest = distance.argmin(axis=1)
    reached = distance[np.arange(len(nearest)), nearest] < np.inf
    return np.where(reached, circles.ball.take(nearest), np.nan)


def distinct(center: Array, area: Array) -> tuple[Array, Array]:
    """Blobs without those that another window shows too, or that another part of the same ball stands for."""
    if len(center) < 2:
        return center, area
    first = (distances(center, center) < SAME).argmax(axis=1) == np.arange(len(center))
    return (center, area) if first.all() else (center[first], area[first])
