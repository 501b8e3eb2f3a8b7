"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.geometry import undistort
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.components import above_local_peak, clipped, components, of_size
from followspot_balls.search import Circles, Regions, distances, search_regions, side_by_side, within
from followspot_balls.strip import Strip, at_border, clusters, cut, scattered, window_strip
from followspot_balls.votes import disc_centers

SAME = 0.5
"""Distance below which blobs of two windows are one, px."""


class Limits(NamedTuple):
    """What may be a ball in each of V views, (V,) each."""

    darkest: Array
    brightest: Array
    smallest: Array
    """px."""
    largest: Array
    """px."""


class Found(NamedTuple):
    """Blobs of all views."""

    pixel: Array
    area: Array
    view: Array


NOTHING = Found(np.empty((0, 2)), np.empty(0), np.empty(0, int))


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
        gray = np.array([t.gray.get(name, (256.0, 0.0)) for t in targets]).reshape(-1, 2)
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        self.area = area * [self.params.smallest, self.params.largest]
        self.limits = (
            np.ceil(gray[:, 0].min(initial=255)),
            np.floor(gray[:, 1].max(initial=0)),
            self.area[:, 0].min(initial=1e9),
            self.area[:, 1].max(initial=0),
        )

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        return self.process_together([self], [(frame, forecast)])[0]

    @classmethod
    def process_together(
        cls, stages: Sequence[Self], inputs: Sequence[tuple[Frame, Forecast | None]]
    ) -> list[Blobs]:
        p = stages[0].params
        views = [
            search_regions(stage.room, forecast, p.radius, p.scale)[stage.camera.name]
            for stage, (_, forecast) in zip(stages, inputs, strict=True)
        ]
        limits = Limits(*np.array([stage.limits for stage in stages]).T)
        found = blobs_of([frame.pixels[..., :1] for frame, _ in inputs], side_by_side(views), limits, p)
        return [
            stage.labelled(found, np.flatnonzero(found.view == number), regions.circles)
            for number, (stage, regions) in enumerate(zip(stages, views, strict=True))
        ]

    def labelled(self, found: Found, rows: Array, circles: Circles) -> Blobs:
        """The message of what was found in this camera's view."""
        pixel, area = found.pixel.take(rows, axis=0), found.area.take(rows)
        targets = within(circles, pixel)
        targets &= (area[:, None] >= self.area[:, 0]) & (area[:, None] <= self.area[:, 1])
        chosen = (targets.any(axis=1) & distinct(pixel)).nonzero()[0]
        if len(chosen) < len(rows):
            pixel, area, targets = pixel.take(chosen, axis=0), area.take(chosen), targets.take(chosen, axis=0)
        return Blobs(
            camera=self.camera.name,
            xy=undistort(self.camera, pixel),
            pixel=pixel,
            area=area,
            similarity=np.ones(len(chosen)),
            targets=targets,
        )


def blobs_of(pictures: Sequence[Array], regions: Regions, limits: Limits, p: IrBlobs.Params) -> Found:
    """Bright blobs in the windows, all views at once; in the whole picture where a target is lost."""
    count = len(regions.circles.lost) // len(pictures)
    whole = regions.circles.lost.reshape(len(pictures), count).any(axis=1)
    found = [NOTHING]
    if len(regions.near):
        view = regions.near // count
        rows = np.flatnonzero(~whole.take(view))
        view, corners, sides = view.take(rows), regions.corners.take(rows, axis=0), regions.sides.take(rows)
        if len(rows):
            level, strip = in_windows([pictures[number] for number in view.tolist()], corners, sides)
            level = in_range(level, limits, view.take(strip.part))
            found.append(measured(level, strip, view, regions.circles, limits, p, sides))
    for number in np.flatnonzero(whole).tolist():
        view = np.array([number])
        level, strip = in_picture(in_range(pictures[number][..., 0], limits, view), limits.smallest[view])
        view = np.full(len(strip.shift), number)
        found.append(measured(level, strip, view, regions.circles, limits, p))
    return found[-1] if len(found) < 3 else Found(*map(np.concatenate, zip(*found, strict=True)))


def in_windows(pictures: Sequence[Array], corners: Array, sides: Array) -> tuple[Array, Strip]:
    """The windows in a strip of grey levels."""
    return cut(pictures, corners, sides)[..., 0], window_strip(corners, sides)


def in_picture(level: Array, smallest: Array) -> tuple[Array, Strip]:
    """Bright pixels of a whole picture, gathered into a strip; smallest: (1,) number of a cluster."""
    index = np.flatnonzero(level)
    y, x = np.divmod(index, level.shape[1])
    found = clusters(np.zeros(len(index), int), y, x, (1, *level.shape), smallest)
    return scattered(found, level.reshape(-1).take(index.take(found.entry))), found.strip


def in_range(gray: Array, limits: Limits, view: Array) -> Array:
    """Grey levels in the range of their view, 0 elsewhere. gray: (H, W) u8; view: (W,), or (1,) of all."""
    darkest, brightest = limits.darkest.astype(np.uint8), limits.brightest.astype(np.uint8)
    shown = (gray >= darkest.take(view)) & (gray <= brightest.take(view))
    return np.asarray(shown.view(np.uint8) * gray)


def measured(
    level: Array,
    strip: Strip,
    view: Array,
    circles: Circles,
    limits: Limits,
    p: IrBlobs.Params,
    sides: Array | None = None,
) -> Found:
    """Bright blobs of a strip.

    view: (N,) of each part; circles: of all views; sides: (N,) px, where the parts are windows.
    """
    blobs = components(above_local_peak(level, p.edge), level, strip)
    seen = view.take(blobs.part)
    keep = of_size(blobs.area, limits.smallest.take(seen), limits.largest.take(seen), seen)
    if sides is not None:
        keep &= ~clipped(blobs, at_border(blobs.pixels, strip.part, sides))
    rows = keep.nonzero()[0]
    radius = np.full(len(keep), np.nan)
    radius[rows] = nearest_radius(
        circles, blobs.center.take(rows, axis=0), seen.take(rows), len(limits.darkest)
    )
    center = disc_centers(level, strip, blobs, radius + p.rim, p.edge)
    return Found(center.take(rows, axis=0), blobs.area.take(rows), seen.take(rows))


def nearest_radius(circles: Circles, pixel: Array, view: Array, views: int) -> Array:
    """Radius of the ball whose forecast is nearest to each blob, NaN without one: (N,) px.

    circles: of all views, so many; pixel: (N, 2) px; view: (N,) that each blob is seen in.
    """
    count = len(circles.ball) // views
    if not (count and len(pixel)):
        return np.full(len(pixel), np.nan)
    center, radius, ball = (a.reshape(views, count, *a.shape[1:]).take(view, axis=0) for a in circles[:3])
    distance = distances(pixel, center)
    distance = np.where(distance <= radius + ball, distance, np.inf)
    nearest = np.arange(len(pixel)), distance.argmin(axis=1)
    return np.where(distance[nearest] < np.inf, ball[nearest], np.nan)


def distinct(center: Array) -> Array:
    """Blobs without those that another window shows too, or that another part of the same ball stands for.

    center: (N, 2) px. Returns (N,) bool.
    """
    near = distances(center, center) < SAME
    first = np.ones(len(center), bool)
    if np.count_nonzero(near) > len(center):
        first[near.argmax(axis=1) < np.arange(len(center))] = False
    return first
