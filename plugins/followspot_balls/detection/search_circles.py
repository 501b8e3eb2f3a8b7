"""Search regions of targets in the views: circles around their forecasts (Jin & Qian 2008, eq. 3)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, Forecast
from followspot_balls.detection.neighbours import beside
from followspot_balls.scene.targets import lost_targets, target_radii

MARGIN = 2
"""Margin of a window around a ball on its search circle, px: blobs at the window's edge may be cut off."""
USUAL = 320.0
"""Longer side of the pictures that the smallest search radius is for, px. In larger ones it grows in
proportion, because a target travels as many more pixels in a frame."""
TINY = 1e-150
"""Added to a coordinate, m, so that a point on the optical axis has a direction away from it; its square is
above 0."""


class Circles(NamedTuple):
    """Search regions of one view or several, a row for each target of each view in turn."""

    center: Array
    """(T, 2) px, as in the picture; NaN behind the camera and for lost targets."""
    radius: Array
    """(T,) px."""
    ball: Array
    """(T,) px, radius of the target's outline; NaN if the centre is."""
    lost: Array
    """(T,) bool: looked for in the whole image."""
    beside: Array
    """(T,) bool: another target is forecast so near that one may cover a part of the other."""


class Regions(NamedTuple):
    """Search regions of some views, and square windows around those that reach into their pictures.

    Rows are the targets of each view in turn.
    """

    circles: Circles
    near: Array
    """(M,) rows that have a window."""
    corners: Array
    """(M, 2) int px, upper left corners of the windows."""
    sides: Array
    """(M,) int px, of the windows."""


class RoomRegions(NamedTuple):
    """Search regions of all C views of a room: C * T rows, the targets of each view in turn."""

    circles: Circles
    inside: Array
    """(C * T,) bool, which have a window."""
    corners: Array
    """(C * T, 2) int px, of the windows; undefined without one."""
    sides: Array
    """(C * T,) int px, likewise."""


class Images(NamedTuple):
    """Forecasts as the C views of a room show them; NaN behind a camera and for lost targets."""

    center: Array
    """(C, T, 2) px."""
    travel: Array
    """(C, T) px, expected from frame to frame."""
    ball: Array
    """(C, T) px, radius of the outline."""


class Pictures(NamedTuple):
    """Picture sizes of the C views of a room."""

    half: Array
    """(C, 1, 2) px, half of their width and height."""
    side: Array
    """(C, 1) px, the longer of these."""
    scale: Array
    """(C, 1) factor of the smallest search radius."""


def search_radius(travel: Array, minimum: float | Array, scale: float) -> Array:
    """T_2D: `minimum` while the expected travel is at most that, else `scale` times the travel (eq. 3).

    travel: (...,) px between the last two estimates, NaN if one has no image; minimum: px, for all or (C, 1).
    """
    return np.asarray(np.where(travel > minimum, scale * travel, minimum))


def search_circles(
    room: Room, camera: str, forecast: Forecast | None, minimum: float, scale: float
) -> Circles:
    """Circles around the forecasts reprojected into one view (section 3.3), and the balls in them.

    minimum: px, in a picture of `USUAL` pixels; scale: of the expected travel.
    """
    return search_regions(room, [camera], [forecast], minimum, scale).circles


def search_regions(
    room: Room, cameras: Sequence[str], forecasts: Sequence[Forecast | None], minimum: float, scale: float
) -> Regions:
    """Search regions of some views, from the forecast of each."""
    if len(set(forecasts)) > 1:  # a camera lags behind
        alone = zip(cameras, forecasts, strict=True)
        return side_by_side([search_regions(room, [c], [f], minimum, scale) for c, f in alone])
    everywhere = room_regions(room, forecasts[0], minimum, scale)
    rows = view_rows(room, tuple(cameras))
    circles = Circles(*(column.take(rows, axis=0) for column in everywhere.circles))
    near = everywhere.inside.take(rows).nonzero()[0]
    rows = rows.take(near)
    return Regions(circles, near, everywhere.corners.take(rows, axis=0), everywhere.sides.take(rows))


@lru_cache(maxsize=8)
def room_regions(room: Room, forecast: Forecast | None, minimum: float, scale: float) -> RoomRegions:
    """Search regions of all views at once; the stages of a worker share the cached result."""
    views, count = len(room.cameras), len(room.targets)
    lost = lost_targets(forecast, count)
    rows_lost = lost[None].repeat(views, axis=0).reshape(-1)
    if forecast is None or lost.all():
        nowhere, nothing = np.full((views * count, 2), np.nan), np.zeros((views * count, 2), int)
        alone = np.zeros(views * count, bool)
        circles = Circles(nowhere, np.full(views * count, minimum), nowhere[:, 0], rows_lost, alone)
        return RoomRegions(circles, np.zeros(views * count, bool), nothing, nothing[:, 0])
    images = forecast_images(room, forecast)
    pictures = room_pictures(room)
    radius = search_radius(images.travel, minimum * pictures.scale, scale)
    inside = reaching(images.center, radius, pictures)
    corners, sides = windows(images.center, radius + images.ball, inside, pictures)
    center, ball = images.center.reshape(-1, 2), images.ball.reshape(-1)
    crowded = beside(images.center, images.ball).reshape(-1)
    circles = Circles(center, radius.reshape(-1), ball, rows_lost, crowded)
    return RoomRegions(circles, inside.reshape(-1), corners.reshape(-1, 2), sides.reshape(-1))


@lru_cache(maxsize=8)
def view_rows(room: Room, cameras: tuple[str, ...]) -> Array:
    """Rows of some views in the arrays of all views: (views * T,)."""
    numbers = np.array([list(room.cameras).index(camera) for camera in cameras])
    count = len(room.targets)
    return np.asarray((numbers[:, None] * count + np.arange(count)).reshape(-1))


def side_by_side(views: Sequence[Regions]) -> Regions:
    """The concatenated regions of several views."""
    circles = Circles(*map(np.concatenate, zip(*(view.circles for view in views), strict=True)))
    count = len(views[0].circles.lost)
    near = np.concatenate([view.near + number * count for number, view in enumerate(views)])
    corners = np.concatenate([view.corners for view in views])
    return Regions(circles, near, corners, np.concatenate([view.sides for view in views]))


@lru_cache(maxsize=8)
def forecast_images(room: Room, forecast: Forecast) -> Images:
    """Forecasts reprojected into all views at once; the stages of a worker share the cached result."""
    views, count, radii = room_views(room), len(room.targets), target_radii(room)
    here = forecast.xyz
    local = views.local(np.concatenate([forecast.last, here, here, forecast.before, here, here]))
    around, outward = across(local[:, count : 2 * count])
    outward *= radii[:, None] / 2  # to both sides, because the outer half looks longer
    local[:, 2 * count : 3 * count] -= outward
    local[:, 4 * count : 5 * count] += around * radii[:, None]
    local[:, 5 * count :] += outward
    start, end = views.project_local(local).reshape(len(local), 2, 3, count, 2).swapaxes(0, 1)
    offset = end - start
    travel, narrow, long = np.hypot(offset[..., 0], offset[..., 1]).swapaxes(0, 1)
    center, ball = start[:, 1], (narrow + long) / 2
    lost = forecast.state == LOST
    if np.count_nonzero(lost):
        center[:, lost], ball[:, lost] = np.nan, np.nan
    return Images(center, travel, ball)


@lru_cache(maxsize=8)
def room_views(room: Room) -> Views:
    """The cameras of a room."""
    return Views(room.cameras.values())


@lru_cache(maxsize=8)
def room_pictures(room: Room) -> Pictures:
    """The picture sizes of a room's cameras."""
    size = np.array([camera.size for camera in room.cameras.values()]).reshape(-1, 1, 2)
    side = size.max(axis=2, initial=0)
    return Pictures(size / 2, side, np.maximum(1.0, side / USUAL))


def across(local: Array) -> Array:
    """Unit vectors square to rays, along which the semi-axes of a sphere's outline lie: (2, C, T, 3).

    The first goes around the optical axis, the second away from it. How long their images are depends on the
    lens: a pinhole camera draws a sphere aside longer outwards, a fisheye hardly.
    local: (C, T, 3) m, in camera coordinates.
    """
    x, y, z = local[..., 0] + TINY, local[..., 1], local[..., 2]
    aside2 = x * x + y * y
    aside = np.sqrt(aside2)
    cos, sin = x / aside, y / aside
    axes = np.zeros((2, 3, *x.shape))  # each coordinate is contiguous, which makes arithmetic faster
    np.negative(sin, out=axes[0, 0])
    axes[0, 1] = cos
    np.multiply(cos, z, out=axes[1, 0])
    np.multiply(sin, z, out=axes[1, 1])
    np.negative(aside, out=axes[1, 2])
    axes[1] /= np.sqrt(aside2 + z * z)
    return np.asarray(axes.transpose(0, 2, 3, 1))


def distances(points: Array, centers: Array) -> Array:
    """Distances between all points and centres: (N, 2) and (T, 2) or (N, T, 2) px -> (N, T)."""
    right, down = points[:, :1] - centers[..., 0], points[:, 1:] - centers[..., 1]
    return np.asarray(np.sqrt(right * right + down * down))


def within(circles: Circles, pixel: Array) -> Array:
    """Which points lie in which target's search region: (N, 2) px -> (N, T) bool; a lost target's region is
    the whole picture.
    """
    inside = distances(pixel, circles.center) <= circles.radius
    inside |= circles.lost
    return inside


def reaching(center: Array, radius: Array, pictures: Pictures) -> Array:
    """Which search regions reach into the picture: (C, T, 2) px and (C, T) px -> (C, T) bool."""
    inside = np.abs(center - pictures.half) <= pictures.half + radius[..., None]
    return np.asarray(inside[..., 0] & inside[..., 1])


def windows(center: Array, reach: Array, inside: Array, pictures: Pictures) -> tuple[Array, Array]:
    """Squares around search regions, so large that a ball on the circle is whole in them.

    center: (C, T, 2) px; reach: (C, T) px; inside: (C, T) bool, which have a window. Returns the upper left
    corners, (C, T, 2) int px, and the sides, (C, T) int px; none exceeds twice the picture.
    """
    half = np.fmin(reach, pictures.side).astype(int) + MARGIN
    nearest = np.rint(np.where(inside[..., None], center, 0)).astype(int)
    return nearest - half[..., None], 2 * half + 1
