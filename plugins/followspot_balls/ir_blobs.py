"""Reflective balls in an infrared camera, by grey level and size (Jin & Qian 2008, sections 2.2 and 3.3)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple, Self

import numpy as np

from followspot import Array, Camera, Field, Latest, Mistake, Room, Stage
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.detection.components import above_local_peak, clipped, components, of_size
from followspot_balls.detection.detector import DetectionParams, Detections, blobs_by_view, without_template
from followspot_balls.detection.gray_levels import Limits, in_pictures, in_range
from followspot_balls.detection.hough import disc_centers, own_area
from followspot_balls.detection.search_circles import Circles, Regions, distances, search_regions, within
from followspot_balls.detection.strip import Strip, Windows, abreast, cut, window_strip
from followspot_balls.detection.touching_balls import divided, touching

SAME = 0.5
"""Distance below which blobs of two windows are one, px."""


class Found(NamedTuple):
    """Blobs of all views."""

    pixel: Array
    area: Array
    view: Array


NOTHING = Found(np.empty((0, 2)), np.empty(0), np.empty(0, int))


class IrBlobs(Stage):
    """Find bright blobs near the forecasts, in the whole image for lost targets; they bear no label."""

    per_camera = True
    advice = (
        "learn the templates in this light (`followspot calibrate targets`), or widen minimum_area and "
        "maximum_area"
    )

    class Params(DetectionParams):
        edge_level: float = Field(
            0.45,
            gt=0,
            lt=1,
            unit="1",
            description="brightness of a blob's edge over its peak; raising it shrinks blobs and separates "
            "them",
        )
        radius_offset: float = Field(
            -0.5,
            unit="px",
            description="measured minus true radius of a ball; negative if patches are dimmer at the edge; "
            "raising it expects larger discs, which moves the centres of partly hidden balls",
        )

    params: Params

    @classmethod
    def check_room(cls, params: Params, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Warn about targets without a template."""
        return without_template(room, cameras, "infrared", lambda target: target.gray)

    def setup(self) -> None:
        name = self.camera.name
        targets = self.room.targets.values()
        gray = np.array([t.gray.get(name, (256.0, 0.0)) for t in targets]).reshape(-1, 2)
        area = np.array([t.area.get(name, (1.0, 0.0)) for t in targets]).reshape(-1, 2)
        area *= [self.params.minimum_area, self.params.maximum_area]
        self.limits = Limits(
            np.ceil(gray[:, 0].min(initial=255)).astype(np.uint8),
            np.floor(gray[:, 1].max(initial=0)).astype(np.uint8),
            area[:, 0].min(initial=1e9),
            area[:, 1].max(initial=0),
            area,
        )
        self.joint: tuple[tuple[IrBlobs, ...], Limits] = (self,), joint_limits((self,))

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        return self.process_together([self], [(frame, forecast)])[0]

    @classmethod
    def process_together(
        cls, stages: Sequence[Self], inputs: Sequence[tuple[Frame, Forecast | None]]
    ) -> list[Blobs]:
        p, cameras = stages[0].params, [stage.camera for stage in stages]
        names, forecasts = [camera.name for camera in cameras], [forecast for _, forecast in inputs]
        regions = search_regions(
            stages[0].room, names, forecasts, p.minimum_search_radius, p.search_radius_scale
        )
        limits = stages[0].limits_with(tuple(stages))
        circles = of_views(regions.circles, len(cameras))
        found = blobs_of([frame.pixels[..., :1] for frame, _ in inputs], regions, circles, limits, p)
        pixel, area, view = found
        targets = within(circles_of(circles, view), pixel)
        allowed = limits.areas.take(view, axis=0)
        targets &= (area[:, None] >= allowed[..., 0]) & (area[:, None] <= allowed[..., 1])
        labelled = Detections(pixel, area, np.ones(len(area)), targets)
        rows = (targets.any(axis=1) & distinct(pixel, view)).nonzero()[0]
        return blobs_by_view(cameras, view, labelled, rows)

    def limits_with(self, stages: tuple[IrBlobs, ...]) -> Limits:
        """Limits of the views of several stages, which are the same at most firings.

        The stage holds them: a cache of the module would hold the stages, and with them runs that have ended.
        """
        if self.joint[0] != stages:
            self.joint = stages, joint_limits(stages)
        return self.joint[1]


def joint_limits(stages: tuple[IrBlobs, ...]) -> Limits:
    """Limits of the views of several stages."""
    return Limits(*map(np.array, zip(*(stage.limits for stage in stages), strict=True)))


def blobs_of(
    pictures: Sequence[Array], regions: Regions, circles: Circles, limits: Limits, p: IrBlobs.Params
) -> Found:
    """Bright blobs in the windows of all views at once, and in the whole picture if a target is lost.

    circles: (V, T, ...) of each view.
    """
    count = circles.lost.shape[1]
    whole = np.asarray(circles.lost.any(axis=1))
    found = [NOTHING]
    if len(regions.near):
        view = regions.near // count
        rows = (~whole.take(view)).nonzero()[0]
        view, corners, sides = view.take(rows), regions.corners.take(rows, axis=0), regions.sides.take(rows)
        if len(rows):
            windows = abreast(corners, sides)
            strip = window_strip(windows)
            level = cut([pictures[number] for number in view.tolist()], windows)[..., 0]
            level = in_range(level, limits, view.take(strip.part))
            found.append(measured(level, strip, view, circles, limits, p, windows))
    seeking = whole.nonzero()[0]
    if len(seeking):
        level, strip, view = in_pictures([pictures[n] for n in seeking.tolist()], seeking, limits)
        found.append(measured(level, strip, view, circles, limits, p))
    return found[-1] if len(found) < 3 else Found(*map(np.concatenate, zip(*found, strict=True)))


def measured(
    level: Array,
    strip: Strip,
    view: Array,
    circles: Circles,
    limits: Limits,
    p: IrBlobs.Params,
    windows: Windows | None = None,
) -> Found:
    """Bright blobs of a strip.

    view: (N,) of each part; circles: (V, T, ...) of each view; windows: of the parts, if they are windows.
    """
    blobs = components(above_local_peak(level, p.edge_level), level, strip)
    seen = view.take(blobs.part)
    large = touching(blobs.area, seen, circles.ball)
    if len(large):
        around = circles_of(circles, seen.take(large))
        blobs = divided(blobs, large, level, strip, around)
        seen = view.take(blobs.part)
    largest = limits.largest.take(seen)
    bound = largest if windows is None else np.inf
    keep = of_size(blobs.area, limits.smallest.take(seen), bound, seen)
    if windows is not None:
        keep &= ~clipped(blobs, strip, windows)
    rows = keep.nonzero()[0]
    near = circles_of(circles, seen.take(rows))
    radius, expected = np.full(len(keep), np.nan), np.full((len(keep), 2), np.nan)
    beside = np.zeros(len(keep), bool)
    expected[rows], radius[rows], beside[rows] = nearest_ball(near, blobs.center.take(rows, axis=0))
    center, rim = disc_centers(level, strip, blobs, radius + p.radius_offset, p.edge_level, expected, beside)
    area = own_area(blobs.area, largest, radius, rim)
    rows = rows[area[rows] <= largest[rows]]
    return Found(center.take(rows, axis=0), area.take(rows), seen.take(rows))


def of_views(circles: Circles, views: int) -> Circles:
    """Search regions of all views in turn, by view: (V * T, ...) -> (V, T, ...). views: so many."""
    return Circles(*(column.reshape(views, -1, *column.shape[1:]) for column in circles))


def circles_of(circles: Circles, view: Array) -> Circles:
    """Search regions in the view of each of N blobs: (V, T, ...) -> (N, T, ...). view: (N,)."""
    return Circles(*[column.take(view, axis=0) for column in circles])


def nearest_ball(circles: Circles, pixel: Array) -> tuple[Array, Array, Array]:
    """The ball whose forecast is nearest to each blob: centre (N, 2) and radius (N,) px, NaN without one,
    and whether it is beside another, (N,) bool.

    circles: for each blob; pixel: (N, 2) px.
    """
    if not circles.ball.size:
        return np.full(pixel.shape, np.nan), np.full(len(pixel), np.nan), np.zeros(len(pixel), bool)
    distance = distances(pixel, circles.center)
    distance = np.where(distance <= circles.radius + circles.ball, distance, np.inf)
    nearest = distance.argmin(axis=1) + np.arange(0, distance.size, distance.shape[1])
    near = distance.take(nearest) < np.inf
    center = np.where(near[:, None], circles.center.reshape(-1, 2).take(nearest, axis=0), np.nan)
    return center, np.where(near, circles.ball.take(nearest), np.nan), near & circles.beside.take(nearest)


def distinct(center: Array, view: Array) -> Array:
    """Marks blobs that no earlier blob duplicates: in another window, or as another part of the same ball.

    center: (N, 2) px; view: (N,) that each is seen in. Returns (N,) bool.
    """
    near = distances(center, center) < SAME
    near &= view[:, None] == view
    first = np.ones(len(center), bool)
    if np.count_nonzero(near) > len(center):
        first[near.argmax(axis=1) < np.arange(len(center))] = False
    return first
