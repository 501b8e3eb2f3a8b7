"""The planes that light is projected onto, and their images in each camera.

All screens share one texture, the atlas: screen k fills the rows from its `row` on, one texel each
1.5 cm, so that a camera looks its projections up in a single remapping.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array, Camera
from followspot.geometry import ray

TEXEL = 0.015
"""Side of a texel, m."""
FLOOR_SIZE, WALL_SIZE = (4.8, 4.8), (4.6, 2.4)
"""Width and height of the lit part of a level and of an upright plane, m."""
THROW = 5.0
"""Distance of a projector from the middle of its screen, m."""


@dataclass(frozen=True, eq=False)
class Screen:
    """A lit rectangle: corner (3,) m, axes (2, 3) unit vectors, size (2,) m, plane (4,), projector (3,) m."""

    corner: Array
    axes: Array
    size: Array
    plane: Array
    projector: Array
    row: int

    def place(self, points: Array) -> Array:
        """Coordinates of points of the plane along the two axes: (..., 3) m -> (..., 2) m."""
        return np.asarray((points - self.corner) @ self.axes.T)

    def texel(self, points: Array) -> Array:
        """Column and row in the atlas of points on the plane: (..., 3) m -> (..., 2)."""
        return np.asarray(self.place(points) / TEXEL + [0, self.row])

    def window(self) -> tuple[int, int, int]:
        """First and last row of the screen in the atlas, and its number of columns."""
        columns, rows = np.round(self.size / TEXEL).astype(int)
        return self.row, self.row + int(rows), int(columns)

    def shadow(self, points: Array) -> tuple[Array, Array]:
        """Shadows of points (N, 3) on the plane, (N, 3) m, and their magnification (N,).

        Both are NaN for points that are not between projector and screen.
        """
        away = points - self.projector
        fall = away @ self.plane[:3]
        reach = -(self.plane[:3] @ self.projector + self.plane[3])
        scale = np.where(fall < -0.2, reach / np.where(fall < -0.2, fall, -1.0), np.nan)
        return self.projector + away * scale[:, None], scale


def screens_of(planes: Iterable[Sequence[float]]) -> tuple[Screen, ...]:
    """One screen on each plane (a, b, c, d), facing the room; level planes lie, others stand."""
    found: list[Screen] = []
    for plane in map(np.array, planes):
        facing = plane if plane @ [0.0, 0.0, 1.0, 1.0] > 0 else -plane
        normal = facing[:3]
        level = abs(normal[2]) > 0.7
        first = np.cross([0.0, 1.0, 0.0] if level else [0.0, 0.0, 1.0], normal)
        first /= np.linalg.norm(first)
        axes = np.stack([first, np.cross(normal, first)])
        size = np.array(FLOOR_SIZE if level else WALL_SIZE)
        foot = -facing[3] * normal
        middle = foot if level else foot + axes[1] * (size[1] / 2 + 0.05)
        corner = middle - size @ axes / 2
        row = found[-1].window()[1] + 2 if found else 0  # dark rows keep neighbours apart
        found.append(Screen(corner, axes, size, facing, middle + THROW * normal, row))
    return tuple(found)


def atlas_size(screens: tuple[Screen, ...]) -> tuple[int, int]:
    """Rows and columns of the atlas."""
    windows = [screen.window() for screen in screens]
    return max((w[1] for w in windows), default=1), max((w[2] for w in windows), default=1)


def rays_of(camera: Camera) -> Array:
    """Viewing direction of every pixel, (H, W, 3) unit vectors in the room."""
    width, height = camera.size
    y, x = np.mgrid[:height, :width].astype(float)
    return ray(camera, np.column_stack([x.ravel(), y.ravel()])).reshape(height, width, 3)


def lookup(camera: Camera, rays: Array, screens: tuple[Screen, ...]) -> tuple[Array, Array]:
    """The point of the screens that each pixel sees.

    Returns the place in the atlas, (H, W, 2) float32, outside of it if there is no screen; and
    the number of the screen, (H, W), or -1.
    """
    place = np.full((*rays.shape[:2], 2), -10.0, np.float32)
    number = np.full(rays.shape[:2], -1)
    nearest = np.full(rays.shape[:2], np.inf)
    for k, screen in enumerate(screens):
        closing = rays @ screen.plane[:3]
        height = screen.plane[:3] @ camera.center + screen.plane[3]
        distance = np.where(closing < -1e-3, height / -np.minimum(closing, -1e-3), np.inf)
        if height <= 0:
            continue  # a camera behind the screen sees nothing of it
        seen = distance < nearest
        texel = screen.texel(camera.center + rays * np.where(seen, distance, 0.0)[..., None])
        first, last, columns = screen.window()
        seen &= (texel[..., 0] >= 0) & (texel[..., 0] <= columns - 1)
        seen &= (texel[..., 1] >= first) & (texel[..., 1] <= last - 1)
        place[seen], number[seen], nearest[seen] = texel[seen], k, distance[seen]
    return place, number


def remapping(place: Array) -> tuple[Array, Array]:
    """The lookup in the form that `cv2.remap` is fastest with."""
    whole, fraction = cv2.convertMaps(place[..., 0], place[..., 1], cv2.CV_16SC2)
    return np.asarray(whole), np.asarray(fraction)
