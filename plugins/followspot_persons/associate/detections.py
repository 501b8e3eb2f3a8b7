"""Detections of one camera from its message: the joints of each person, or the box of each person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from followspot import Array, Camera
from followspot.geometry import undistort
from followspot.people import Boxes
from followspot.points import Points2D
from followspot_persons.associate.colors.torso_colors import torsos, torsos_in

MAXIMUM_DETECTIONS = 60
"""Detections of one picture, those with the best scores."""
MAXIMUM_COORDINATE = 1e5
"""Largest coordinate of a point in a picture, px."""
BORDER = 3.0
"""Distance from the picture's border at which an edge of a box is the picture's, px."""


@dataclass(frozen=True, eq=False)
class Detections:
    """N detections of one camera: its number among the views, the time of exposure, ns, (N, ...) the
    measurements of a body model, and (N, BINS) histograms of the torsos, NaN if unknown.
    """

    camera: int
    time: int
    measured: Array
    colors: Array


class Measured(NamedTuple):
    """N measurements of a body model, and the corners of the torsos in the picture, (N, 4, 2) px."""

    measured: Array
    torsos: Array


def joints_of(points: Points2D, joints: tuple[str, ...], minimum_score: float) -> Measured:
    """Points of each person, (N, J, 2) px undistorted, NaN for joints that were not found; the surest first.

    Points without an instance, or whose label is none of the joints, are left out.
    """
    number = {name: column for column, name in enumerate(joints)}
    column = np.array([number.get(name, -1) for name in points.labels], int)
    label = column[points.label] if len(column) else np.full(len(points.label), -1)
    there = np.isfinite(points.xy).all(axis=1) & (np.abs(points.xy) < MAXIMUM_COORDINATE).all(axis=1)
    used = (label >= 0) & (points.instance >= 0) & there & (points.score >= minimum_score)
    instance, row = np.unique(points.instance[used], return_inverse=True)
    xy = np.full((len(instance), len(joints), 2), np.nan)
    pixel = xy.copy()
    xy[row, label[used]], pixel[row, label[used]] = points.xy[used], points.pixel[used]
    total = np.bincount(row, points.score[used], minlength=len(instance))
    best = np.argsort(-total, kind="stable")[:MAXIMUM_DETECTIONS]
    return Measured(xy[best], torsos(joints, pixel[best]))


def boxes_of(boxes: Boxes, camera: Camera, overlap: float, minimum_score: float) -> Measured:
    """Boxes (N, 4) px undistorted, the surest first; NaN for edges that are the picture's.

    Of boxes that overlap by more than this share of their union, the surest stays.
    """
    box = boxes.box
    usable = np.isfinite(box).all(axis=1) & (np.abs(box) < MAXIMUM_COORDINATE).all(axis=1)
    usable &= (box[:, 2:] > box[:, :2]).all(axis=1) & (boxes.score >= minimum_score)
    box = box[usable][np.argsort(-boxes.score[usable], kind="stable")]
    box = box[_suppressed(box, overlap)][:MAXIMUM_DETECTIONS]
    size = np.array(camera.size, float)
    cut = np.hstack([box[:, :2] < BORDER, box[:, 2:] > size - 1 - BORDER])
    return Measured(np.where(cut, np.nan, _undistorted(box, camera)), torsos_in(box))


def _suppressed(box: Array, overlap: float) -> Array:
    """Rows that stay, in their order."""
    low = np.maximum(box[:, None, :2], box[None, :, :2])
    high = np.minimum(box[:, None, 2:], box[None, :, 2:])
    both = np.maximum(high - low, 0.0).prod(axis=2)
    area = (box[:, 2:] - box[:, :2]).prod(axis=1)
    alike = both > overlap * (area[:, None] + area - both)
    stays = np.ones(len(box), bool)
    for row in range(len(box)):
        if stays[row]:
            stays[row + 1 :] &= ~alike[row, row + 1 :]
    return np.flatnonzero(stays)


def _undistorted(box: Array, camera: Camera) -> Array:
    """Boxes by the undistorted middles of their edges."""
    middle = (box[:, :2] + box[:, 2:]) / 2
    left, right = (np.column_stack([box[:, c], middle[:, 1]]) for c in (0, 2))
    upper, lower = (np.column_stack([middle[:, 0], box[:, c]]) for c in (1, 3))
    flat = undistort(camera, np.vstack([left, upper, right, lower])).reshape(4, -1, 2)
    return np.column_stack([flat[0, :, 0], flat[1, :, 1], flat[2, :, 0], flat[3, :, 1]])
