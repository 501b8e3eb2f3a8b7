"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import above_local_peak, components, cut
from followspot_balls.search import Circles, in_picture, search_circles, windows, within
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
        self.darkest, self.brightest = gray[:, 0].min(initial=256), gray[:, 1].max(initial=0)
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        self.area = area * [self.params.smallest, self.params.largest]
        self.sought = np.array([[self.area[:, 0].min(initial=1e9), self.area[:, 1].max(initial=0)]])

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        circles = search_circles(self.camera, forecast, self.sizes, self.params.radius, self.params.scale)
        pixel, area = self.search(frame.pixels, circles)
        fits = (area[:, None] >= self.area[:, 0]) & (area[:, None] <= self.area[:, 1])
        targets = within(circles, pixel) & fits
        keep = targets.any(axis=1)
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel[keep]),
            pixel=pixel[keep],
            area=area[keep],
            similarity=np.ones(int(keep.sum())),
            targets=targets[keep],
        )

    def search(self, pixels: Array, circles: Circles) -> tuple[Array, Array]:
        """Centres (N, 2) px and areas (N,) px of bright blobs, each once, in the windows or the picture."""
        height, width = pixels.shape[:2]
        if circles.lost.any():
            corners = np.zeros((1, 2), int)
        else:
            near = in_picture(circles, self.camera.size)
            corners, height = windows(circles, near, self.camera.size)
            width = height
        if not len(corners):
            return np.empty((0, 2)), np.empty(0)
        gray = cut(pixels, corners, height, width)[..., 0]
        level = np.where((gray >= self.darkest) & (gray <= self.brightest), gray, np.uint8(0))
        blobs = components(above_local_peak(level, self.params.edge), level, self.sought)
        corner = corners[blobs.tile]
        radius = nearest_radius(circles, blobs.center + corner)
        center = disc_centers(level, blobs, radius + self.params.rim, self.params.edge) + corner
        whole = ~blobs.clipped | circles.lost.any()
        return distinct(center[whole], blobs.area[whole])


def nearest_radius(circles: Circles, pixel: Array) -> Array:
    """Radius of the ball whose forecast is nearest to each blob: (N, 2) px -> (N,) px, NaN without one."""
    if not circles.ball.size:
        return np.full(len(pixel), np.nan)
    distance2 = np.square(pixel[:, None] - circles.center).sum(axis=2)
    inside = distance2 <= np.square(circles.radius + circles.ball)
    nearest = np.where(inside, distance2, np.inf).argmin(axis=1)
    return np.where(inside.any(axis=1), circles.ball[nearest], np.nan)


def distinct(center: Array, area: Array) -> tuple[Array, Array]:
    """Blobs without those that another window shows too."""
    if len(center) < 2:
        return center, area
    apart = np.abs(center[:, None] - center).max(axis=2) >= SAME
    first = (apart | np.tri(len(center), dtype=bool).T).all(axis=1)
    return center[first], area[first]
