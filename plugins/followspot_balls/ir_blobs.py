"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import above_local_peak, components, cut
from followspot_balls.search import Circles, search_circles
from followspot_balls.votes import disc_centers

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
        self.margin = 2 + int(np.sqrt(4 / np.pi * area[:, 1].max(initial=1)))

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        p = self.params
        circles = search_circles(self.camera, forecast, self.sizes, p.radius, p.scale)
        left, top, right, bottom = window(circles, self.margin, frame.pixels.shape)
        tile = cut(frame.pixels[top:bottom, left:right], np.zeros((1, 2), int), bottom - top, right - left)
        gray = tile[..., 0]
        level = np.where((gray >= self.darkest) & (gray <= self.brightest), gray, np.uint8(0))
        blobs = components(above_local_peak(level, p.edge), level, self.sought)
        near = membership(circles, blobs.center + np.array([left, top]), self.margin)
        ball = expected_radius(circles, blobs.center + np.array([left, top]))
        pixel = disc_centers(level, blobs, ball + p.rim, p.edge) + np.array([left, top])
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


def window(circles: Circles, margin: int, shape: tuple[int, ...]) -> Window:
    """The rectangle around all search regions within the picture: left, top, right, bottom, px.

    It is the whole picture while a target is lost.
    """
    height, width = shape[:2]
    if circles.lost.any():
        return 0, 0, width, height
    seen = ~np.isnan(circles.ball)
    if not seen.any():
        return 0, 0, 0, 0
    half = circles.radius[seen, None] + margin
    low, high = (circles.center[seen] - half).min(axis=0), (circles.center[seen] + half).max(axis=0)
    left, top = np.clip(low, 0, [width, height]).astype(int).tolist()
    right, bottom = np.clip(np.ceil(high) + 1, 0, [width, height]).astype(int).tolist()
    return left, top, right, bottom


def membership(circles: Circles, pixel: Array, margin: int) -> Array:
    """Which blobs lie in which target's search region: (N, 2) px -> (N, T) bool; in a lost one's all do."""
    offset = np.abs(pixel[:, None] - circles.center).max(axis=2)
    return np.asarray(circles.lost | (offset <= circles.radius + margin))


def expected_radius(circles: Circles, pixel: Array) -> Array:
    """Radius of the ball forecast nearest to each blob: (N, 2) px -> (N,) px, NaN without one."""
    distance = np.linalg.norm(pixel[:, None] - circles.center, axis=2)
    distance = np.where(np.isnan(distance), np.inf, distance)
    if not distance.size:
        return np.full(len(pixel), np.nan)
    nearest = distance.argmin(axis=1)
    within = distance[np.arange(len(pixel)), nearest] <= circles.radius[nearest]
    return np.where(within, circles.ball[nearest], np.nan)
