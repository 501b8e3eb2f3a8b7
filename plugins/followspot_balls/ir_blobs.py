"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import above_local_peak, components, cut
from followspot_balls.search import Circles, outline_radius, search_circles
from followspot_balls.votes import disc_centers

WINDOW = 1.5
"""Balls' radii by which a window exceeds its search circle, so that a ball at its edge is whole."""
Window = tuple[int, int, int, int]


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
        self.darkest, self.brightest = gray[:, 0].min(initial=256), gray[:, 1].max(initial=0)
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        self.area = area * [self.params.smallest, self.params.largest]
        self.sought = np.array([[self.area[:, 0].min(initial=1e9), self.area[:, 1].max(initial=0)]])

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        circles = search_circles(self.camera, forecast, len(self.sizes), p.radius, p.scale)
        ball = self.outlines(circles, forecast)
        reach = circles.radius + WINDOW * ball + 3
        left, top, right, bottom = window(circles, reach, frame.pixels.shape)
        tile = cut(frame.pixels[top:bottom, left:right], np.zeros((1, 2), int), bottom - top, right - left)
        gray = tile[..., 0]
        level = np.where((gray >= self.darkest) & (gray <= self.brightest), gray, np.uint8(0))
        blobs = components(above_local_peak(level, p.edge), level, self.sought)
        corner = np.array([left, top])
        offset = blobs.center[:, None] + corner - circles.center
        near = circles.lost | (np.abs(offset).max(axis=2) <= reach)
        radius = nearest_radius(offset, circles.radius, ball)
        pixel = disc_centers(level, blobs, radius + p.rim, p.edge) + corner
        area = blobs.area[:, None]
        targets = near & (area >= self.area[:, 0]) & (area <= self.area[:, 1])
        keep = targets.any(axis=1)
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel[keep]),
            pixel=pixel[keep],
            area=blobs.area[keep],
            similarity=np.ones(int(keep.sum())),
            targets=targets[keep],
        )

    def outlines(self, circles: Circles, forecast: Forecast | None) -> Array:
        """Radii of the targets in the picture, (T,) px; NaN where they have no forecast."""
        if forecast is None or circles.lost.all():
            return np.full(len(self.sizes), np.nan)
        return outline_radius(self.camera, circles.center, forecast.xyz, self.sizes)


def window(circles: Circles, reach: Array, shape: tuple[int, ...]) -> Window:
    """The rectangle around all search regions within the picture: left, top, right, bottom, px.

    It is the whole picture while a target is lost. reach: (T,) px from the centres.
    """
    height, width = shape[:2]
    if circles.lost.any():
        return 0, 0, width, height
    seen = ~np.isnan(circles.center[:, 0])
    if not seen.any():
        return 0, 0, 0, 0
    center, half = circles.center[seen], reach[seen, None]
    low, high = (center - half).min(axis=0), (center + half).max(axis=0) + 2
    left, top = np.clip(low, 0, [width, height]).astype(int).tolist()
    right, bottom = np.clip(high, 0, [width, height]).astype(int).tolist()
    return left, top, right, bottom


def nearest_radius(offset: Array, reach: Array, ball: Array) -> Array:
    """Radius of the ball whose forecast is nearest to each blob, (N,) px; NaN without one in reach.

    offset: (N, T, 2) px from the forecasts, NaN without one; reach, ball: (T,) px.
    """
    distance2 = np.square(offset).sum(axis=2)
    inside = distance2 <= np.square(reach)
    if not inside.size:
        return np.full(len(offset), np.nan)
    nearest = np.where(inside, distance2, np.inf).argmin(axis=1)
    return np.where(inside.any(axis=1), ball[nearest], np.nan)
