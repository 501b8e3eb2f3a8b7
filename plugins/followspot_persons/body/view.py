"""Images of the features of posed bodies in a camera.

A body is small against its distance, so five of its points are projected by the camera's own model, and
the features are placed between them, to first order of their distance from the body's axis. This holds for
every model of a camera and costs five projections a body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_persons.body.shape import ShapeModel, turn
from followspot_persons.body.standing import WAIST
from followspot_persons.panorama import full_turn, short_way, turn_of

X, Y, HEIGHT, HEADING, PAN, TILT = range(6)
"""Columns of a pose: m, m, m, rad, rad, rad; in the room."""
ARM = 0.1
"""Length beside the axis that measures the scale across, m."""
MIN_DISTANCE = 0.3
"""Smallest distance of a body from the camera's axis, m; nearer ones are projected from there."""


@dataclass(frozen=True, eq=False)
class Bearing:
    """How P bodies stand towards the camera: distance on the floor (m), relative headings of chest and face
    (rad, 0 towards the camera), and the unit vectors (P, 2) to the camera and to the right in its picture.
    """

    distance: Array
    torso: Array
    head: Array
    toward: Array
    right: Array


@dataclass(frozen=True, eq=False)
class BodyView:
    """P bodies in a picture.

    edge: (P, E, 2) and surface: (P, F, 2) px float32; normal: (P, E) rad, of the edges; visibility: (P, F);
    box: (P, 4) px, x0 y0 x1 y1 of the upper body, not cut at the picture's edge nor wrapped. Places in the
    picture are NaN if a body has no image; its edges then have the normals of an upright one.
    """

    edge: Array
    normal: Array
    surface: Array
    visibility: Array
    box: Array
    bearing: Bearing


def bearing(camera: Camera, pose: Array) -> Bearing:
    """Poses of bodies relative to a camera. pose: (P, 6)."""
    to_camera = camera.center[:2] - pose[:, :2]
    distance = np.hypot(to_camera[:, 0], to_camera[:, 1])
    toward = to_camera / np.maximum(distance, 1e-6)[:, None]
    torso = pose[:, HEADING] - np.arctan2(toward[:, 1], toward[:, 0])
    right = np.column_stack([-toward[:, 1], toward[:, 0]])
    return Bearing(distance, torso, torso + pose[:, PAN], toward, right)


def view(camera: Camera, shape: ShapeModel, pose: Array) -> BodyView:
    """Features of posed bodies in the picture. pose: (P, 6)."""
    stand = bearing(camera, pose)
    turned = turn(shape, stand.torso, stand.head, pose[:, TILT])
    axes = _axes(camera, pose, stand)
    lean = np.nan_to_num(np.arctan2(-axes.down[:, 0], axes.down[:, 1]))
    normal = shape.outline.normal + lean[:, None]
    edge = _placed(turned.edge, axes)
    low = axes.top[:, 1] + (1 - WAIST) * axes.down[:, 1]
    box = np.column_stack([edge[..., 0].min(axis=1), edge[..., 1].min(axis=1), edge[..., 0].max(axis=1), low])
    return BodyView(edge, normal, _placed(turned.surface, axes), turned.visibility, box, stand)


@dataclass(frozen=True, eq=False)
class _Axes:
    """What a body height is in the picture, (P, 2) px each: downwards, to the right, and towards the camera
    at the height of the head's top (`near`), and how the latter changes downwards (`near_down`).
    """

    top: Array
    down: Array
    right: Array
    near: Array
    near_down: Array


def _axes(camera: Camera, pose: Array, stand: Bearing) -> _Axes:
    """From images of five points: head's top and waist on the axis and before it, and beside the chest."""
    count, height = len(pose), pose[:, HEIGHT]
    place = stand.toward * np.minimum(stand.distance - MIN_DISTANCE, 0.0)[:, None] + pose[:, :2]
    before, beside = place + ARM * stand.toward, place + ARM * stand.right
    points = np.empty((5, count, 3))
    points[..., :2] = place, place, before, before, beside
    points[..., 2] = np.outer([1, WAIST, 1, WAIST, (1 + WAIST) / 2], height)
    pixel = project(camera, points.reshape(-1, 3)).reshape(5, count, 2)
    if turn := turn_of(camera):
        pixel[1:, :, 0] = pixel[0, :, 0] + short_way(pixel[1:, :, 0] - pixel[0, :, 0], turn)
    top, low, top_near, low_near, side = pixel
    per_height = (height / ARM)[:, None]
    near, below = (top_near - top) * per_height, 1 - WAIST
    near_down = ((low_near - low) * per_height - near) / below
    return _Axes(top, (low - top) / below, (side - (top + low) / 2) * per_height, near, near_down)


def _placed(features: Array, axes: _Axes) -> Array:
    """Features, (P, features, 3) right, up and towards the camera, in the picture: (P, features, 2) px."""
    right, below, near = features[..., 0], 1 - features[..., 1], features[..., 2]
    out = np.empty((2, *right.shape), np.float32)
    columns = (v.T.astype(np.float32)[..., None] for v in vars(axes).values())
    for place, top, down, across, closer, closer_down in zip(out, *columns, strict=True):
        np.multiply(near, closer_down, out=place)
        place += down
        place *= below
        place += top
        place += right * across
        place += near * closer
    return np.moveaxis(out, 0, -1)


def pixel_index(camera: Camera, points: Array) -> tuple[Array, Array]:
    """Places in a picture's flattened pixels, and which points lie in the picture.

    points: (..., 2) px. Returns index (...) int, valid everywhere, and inside (...) bool.
    """
    width, height = camera.size
    column, row = np.rint(points[..., 0]), np.rint(points[..., 1])
    if full_turn(camera):
        column -= width * np.floor(column / width)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    with np.errstate(invalid="ignore"):  # what has no image has no index either
        index = row.astype(np.intp) * width + column.astype(np.intp)
    index *= inside
    return index, inside
