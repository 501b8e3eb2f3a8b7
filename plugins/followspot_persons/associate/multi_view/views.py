"""Cameras as matrices: images of points, how they change with the points, and epipolar geometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.frame_times import to_ns
from followspot.geometry import back_projection, fundamental_matrix

NEAREST = 0.1
"""Smallest depth of a point that a camera can see, m."""


@dataclass(frozen=True, eq=False)
class View:
    """A camera for undistorted points. projection: (3, 4), its third row gives the depth in m; center: (3,)
    m; back: (3, 3), from a pixel to the direction of its ray; focal: px; size: width, height, px; offset:
    time of exposure minus time stamp, ns; number: among the cameras of the room.
    """

    name: str
    projection: Array
    center: Array
    back: Array
    focal: float
    size: Array
    offset: int
    number: int


@dataclass(frozen=True, eq=False)
class Views:
    """All cameras of a room. fundamental: (C, C, 3, 3); that of [a, b] takes points of a to lines in b."""

    each: tuple[View, ...]
    center: Array
    back: Array
    focal: Array
    projection: Array
    fundamental: Array


@dataclass(frozen=True)
class Noise:
    """Errors of found points. pixel: sigma in the picture, px; body: sigma on the body, m; delay: sigma of
    the time of exposure, s.
    """

    pixel: float
    body: float
    delay: float


def views_of(cameras: Sequence[Camera]) -> Views:
    """The matrices of these cameras."""
    each = tuple(_view(camera, number) for number, camera in enumerate(cameras))
    F = [
        [np.zeros((3, 3)) if a is b else fundamental_matrix(a.projection, b.projection) for b in each]
        for a in each
    ]
    return Views(
        each,
        np.array([view.center for view in each]).reshape(-1, 3),
        np.array([view.back for view in each]).reshape(-1, 3, 3),
        np.array([view.focal for view in each]),
        np.array([view.projection for view in each]).reshape(-1, 3, 4),
        np.array(F).reshape(len(each), len(each), 3, 3),
    )


def _view(camera: Camera, number: int) -> View:
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    offset = to_ns(camera.clock_offset)
    size = np.array(camera.size, float)
    back = back_projection(camera)
    return View(camera.name, camera.projection, camera.center, back, focal, size, offset, number)


def images(projection: Array, xyz: Array) -> tuple[Array, Array]:
    """Undistorted images (..., 2) px and depths (...) m of points (..., 3) m; NaN behind the camera.

    projection: (3, 4), or one for each point.
    """
    local = (projection[..., :3] @ xyz[..., None])[..., 0] + projection[..., 3]
    depth = np.where(local[..., 2] > NEAREST, local[..., 2], np.nan)
    return local[..., :2] / depth[..., None], depth


def jacobians(projection: Array, there: Array, depth: Array) -> Array:
    """Change of images with their points, (..., 2, 3) px/m, of the results of :func:`images`."""
    top, bottom = projection[..., :2, :3], projection[..., 2:, :3]
    return np.asarray((top - there[..., None] * bottom) / depth[..., None, None])


def rays(back: Array, xy: Array) -> Array:
    """Directions of pixels (..., 2), unit vectors (..., 3). back: (3, 3), or one for each pixel."""
    along = back[..., 0] * xy[..., :1] + back[..., 1] * xy[..., 1:] + back[..., 2]
    return np.asarray(along / np.linalg.norm(along, axis=-1, keepdims=True))
