"""The search for upper bodies: positions, sizes and the linear detector's proposals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array, Camera
from followspot_persons.body.standing import knows_floor, standing
from followspot_persons.hog.window import ABOVE, BODY, HEIGHT, STRIDE, TALL, WIDTH
from followspot_persons.panorama import full_turn, short_way

EDGE = 16
"""Largest part of a window beside or below the picture, where the border is repeated, px of the window."""
WITHIN = STRIDE
"""The same above the picture for windows of whole bodies; those farther up show people without heads."""
COLUMNS = 16
"""Number of columns at which the rows of people are computed."""
SLACK = 1.12
"""Tolerance of the height limits, because windows have discrete positions and sizes."""


@dataclass(frozen=True)
class Level:
    """One size of windows: px of the window per px of the picture, and the rows of the picture to search."""

    scale: float
    top: float
    bottom: float


def levels(
    camera: Camera,
    sizes: tuple[float, float],
    step: float,
    heights: tuple[float, float],
    *,
    above: bool = False,
) -> list[Level]:
    """All sizes of windows from `sizes`, each `step` times the one before, where people may stand.

    sizes: smallest and largest upper body, px; heights: of people, m; above: the windows that reach above the
    picture, instead of all others. Without a floor, all rows.
    """
    count = int(np.floor(np.log(sizes[1] / sizes[0]) / np.log(step)))
    found = [_level(camera, TALL / (sizes[0] * step**i), heights, above) for i in range(count + 1)]
    return [level for level in found if level is not None]


def _level(camera: Camera, scale: float, heights: tuple[float, float], above: bool) -> Level | None:
    width, height = camera.size
    tops = np.arange(-ABOVE, height * scale - HEIGHT + EDGE + 1, STRIDE)
    tops = tops[(tops < -WITHIN) == above] / scale
    if not len(tops):
        return None
    if knows_floor(camera):
        y, x = (grid.ravel() for grid in np.meshgrid(tops, np.linspace(0, width - 1, COLUMNS), indexing="ij"))
        y0 = y + BODY[1] / scale
        allowed = plausible(camera, np.column_stack([x, y0, x, y0 + TALL / scale]), heights)
        tops = tops[allowed.reshape(len(tops), -1).any(axis=1)]
        if not len(tops):
            return None
    return Level(scale, float(tops[0]), float(tops[-1] + HEIGHT / scale))


def plausible(camera: Camera, box: Array, heights: tuple[float, float]) -> Array:
    """Which boxes fit people of these heights, m, on the floor: (N, 4) px -> (N,)."""
    if not knows_floor(camera):
        return np.ones(len(box), bool)
    _, height = standing(camera, box)
    return np.asarray((height > heights[0] / SLACK) & (height < heights[1] * SLACK))


def proposals(
    pixels: Array, camera: Camera, searched: Sequence[Level], hog: cv2.HOGDescriptor
) -> tuple[Array, Array]:
    """Upper bodies that the detector `hog` sees: boxes (N, 4) px, and its scores (N,)."""
    boxes, scores = [np.empty((0, 4))], [np.empty(0)]
    for level in searched:
        if int(level.top) >= len(pixels):  # a smaller picture than the camera's
            continue
        picture, scale, origin = _scaled(pixels, level, full_turn(camera))
        if picture.shape[0] < HEIGHT or picture.shape[1] < WIDTH:
            continue
        corners, score = hog.detect(picture, 0.0, (STRIDE, STRIDE), (0, 0))
        if len(corners):
            place = (np.tile(np.asarray(corners, float), 2) + BODY) / np.tile(scale, 2)
            boxes.append(place + np.tile(origin, 2))
            scores.append(np.ravel(score))
    return np.concatenate(boxes), np.concatenate(scores)


def _scaled(pixels: Array, level: Level, wraps: bool) -> tuple[Array, Array, Array]:
    """The rows of a level in its size, with a border; exact scale (2,), and place (2,) of its corner, px."""
    top, bottom = max(0, int(level.top)), min(len(pixels), int(np.ceil(level.bottom)) + 1)
    part = pixels[top:bottom]
    size = np.maximum(1, np.rint(np.array(part.shape[1::-1]) * level.scale)).astype(int)
    shrinks = cv2.INTER_AREA if level.scale < 1 else cv2.INTER_LINEAR
    picture = cv2.resize(part, size.tolist(), interpolation=shrinks)
    above = max(0, round((top - level.top) * level.scale))
    below = max(0, round((level.bottom - bottom) * level.scale))
    picture = cv2.copyMakeBorder(picture, above, below, 0, 0, cv2.BORDER_REPLICATE)
    left, right, kind = (0, WIDTH, cv2.BORDER_WRAP) if wraps else (EDGE, EDGE, cv2.BORDER_REPLICATE)
    picture = cv2.copyMakeBorder(picture, 0, 0, left, right, kind)
    scale = size / np.array(part.shape[1::-1])
    return np.asarray(picture), scale, np.array([0, top]) - np.array([left, above]) / scale


def overlap(box: Array, others: Array, turn: float) -> Array:
    """Intersection over union of a box (4,) with others (N, 4); turn: width of a panorama, px, else 0."""
    shared, area, areas = _shared(box, others, turn)
    return np.asarray(shared / (area + areas - shared))


def nesting(box: Array, others: Array, turn: float) -> Array:
    """Intersection over the smaller of a box (4,) and each other (N, 4): 1 if one holds the other."""
    shared, area, areas = _shared(box, others, turn)
    return np.asarray(shared / np.minimum(area, areas))


def _shared(box: Array, others: Array, turn: float) -> tuple[Array, float, Array]:
    """Intersections (N,), the area of the box and those of the others (N,), px^2."""
    shift = (others[:, 0] + others[:, 2] - box[0] - box[2]) / 2
    moved = short_way(shift, turn)
    half, half_others = (box[2] - box[0]) / 2, (others[:, 2] - others[:, 0]) / 2
    across = np.minimum(half, moved + half_others) - np.maximum(-half, moved - half_others)
    down = np.minimum(box[3], others[:, 3]) - np.maximum(box[1], others[:, 1])
    area = float((box[2] - box[0]) * (box[3] - box[1]))
    areas = (others[:, 2] - others[:, 0]) * (others[:, 3] - others[:, 1])
    return np.maximum(across, 0) * np.maximum(down, 0), area, areas


def groups(box: Array, score: Array, least: float, turn: float) -> list[Array]:
    """Groups of rows that show the same body: each best one with those that overlap it by `least`; best
    first.

    A row that overlaps a better one never heads a group: non-maximum suppression.
    """
    found, open_rows = [], np.argsort(-score, kind="stable")
    while len(open_rows):
        shared = overlap(box[open_rows[0]], box[open_rows], turn)
        found.append(open_rows[shared >= least])
        open_rows = open_rows[shared < least]
    return found


def outermost(box: Array, odds: Array, most: float, turn: float) -> Array:
    """Rows of boxes that nest with no better one by `most`, best first: a part of a body is no body."""
    kept: list[int] = []
    for row in np.argsort(-odds, kind="stable").tolist():
        if not kept or nesting(box[row], box[kept], turn).max() <= most:
            kept.append(row)
    return np.array(kept, int)
