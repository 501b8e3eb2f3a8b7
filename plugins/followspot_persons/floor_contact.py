"""Where a person stands: the lowest foreground below the body, and the height that follows from it.

A camera above the floor knows the distance of a point on the floor. Feet are nearer to the camera than the
axis of the body, by half a foot and half a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_persons.background import foreground
from followspot_persons.body_view import HEIGHT
from followspot_persons.panorama import full_turn
from followspot_persons.standing import knows_floor, rise

WIDTH = 0.3
"""Half the width of the searched strip, in heights of the upper body."""
SHARE = 0.06
"""Share of a row of the strip that is foreground where a leg is."""
GAP = 0.1
"""Longest gap between two rows of legs, in heights of the upper body: a belt, a bare ankle."""
BEFORE_AXIS = 0.18
"""Distance of the nearer foot's edge from the axis of the body, towards the camera, m."""
LARGEST_CHANGE = 0.25
"""Difference of the distance from that by size, relative, beyond which the lowest row is not that of the
feet: furniture hides the legs, or another person stands before them.
"""
BODY = 0.6
"""Share of the upper half of the strip's middle that is foreground where a person is."""


@dataclass(frozen=True)
class Presence:
    """What the background tells of a person: share of the upper body that is foreground; height by the feet,
    m, None if they are not seen on the floor.
    """

    foreground: float
    height: float | None = None


def presence(
    camera: Camera, pixels: Array, background: Array, light: float, pose: Array, box: Array
) -> Presence | None:
    """Compare a person with the background; None if the person has no image.

    pixels, background: (H, W, 3) u1; light: of the picture; pose: (6,); box: (4,) px, the upper body of this
    pose.
    """
    tall = float(box[3] - box[1])
    head, foot = project(camera, np.array([[*pose[:2], pose[HEIGHT]], [*pose[:2], 0.0]]))
    if not (np.isfinite([*head, *foot]).all() and tall > 0 and foot[1] > head[1]):
        return None
    rows, legs = strip(camera, pixels, background, light, (head, foot), WIDTH * tall)
    chest = legs[rows < box[3]]
    middle = chest[:, chest.shape[1] // 3 : -(chest.shape[1] // 3) or None]
    if not middle.size:
        return None
    share = float(middle.mean())
    if share < BODY or not knows_floor(camera):
        return Presence(share)
    low = int(rows[lowest(legs.mean(axis=1) >= SHARE, max(1, round(GAP * tall)))])
    return Presence(share, height_on_floor(camera, pose, (head, foot), low))


def height_on_floor(camera: Camera, pose: Array, axis: tuple[Array, Array], low: int) -> float | None:
    """Height of a person whose lowest row in the picture is `low`, m; None if it is not that of feet.

    pose: (6,), about; axis: pixels of the head's top and of the point on the floor.
    """
    if low >= camera.size[1] - 2:
        return None
    head, foot = axis
    column = foot[0] + (low - foot[1]) * (foot[0] - head[0]) / (foot[1] - head[1])
    down, up = rise(camera, np.array([column, head[0]]), np.array([low + 0.5, head[1]]))
    if down >= 0:
        return None
    distance = float(-camera.center[2] / down) + BEFORE_AXIS
    by_size = float(np.hypot(*(pose[:2] - camera.center[:2])))
    height = float(camera.center[2] + up * distance)
    return height if abs(distance - by_size) <= LARGEST_CHANGE * by_size else None


def strip(
    camera: Camera, pixels: Array, background: Array, light: float, axis: tuple[Array, Array], half: float
) -> tuple[Array, Array]:
    """Foreground along the axis of a body from head to below the feet: rows (R,) and (R, columns) bool.

    axis: pixels of the head's top and of the point on the floor; half: width to either side, px.
    """
    head, foot = axis
    last = min(camera.size[1], int(foot[1] + 0.5 * (foot[1] - head[1])))
    rows = np.arange(max(0, int(head[1])), max(last, 1))
    middle = head[0] + (rows - head[1]) * (foot[0] - head[0]) / (foot[1] - head[1])
    columns = np.rint(middle).astype(int)[:, None] + np.arange(-int(half), int(half) + 1)
    width = camera.size[0]
    inside = np.ones(columns.shape, bool) if full_turn(camera) else (columns >= 0) & (columns < width)
    columns = columns % width if full_turn(camera) else np.clip(columns, 0, width - 1)
    there = rows[:, None], columns
    return rows, foreground(pixels[there], background[there], light) & inside


def lowest(filled: Array, gap: int) -> int:
    """Last of the rows (R,) bool that are filled from the first filled one on, without a longer gap."""
    found = np.flatnonzero(filled)
    if not len(found):
        return 0
    breaks = np.flatnonzero(np.diff(found) > gap)
    return int(found[breaks[0]] if len(breaks) else found[-1])
