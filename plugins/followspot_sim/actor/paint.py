"""Drawing a surface: the faces that a camera sees, shaded by the lamp, from far to near."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_sim.rendering.outline import SUBPIXEL, fixed_point

AMBIENT, FROM_ABOVE, LAMP = 0.50, 0.14, 0.62
"""Light from all around, more from above, and of the lamp."""
FARTHEST = 16_000
"""Faces that reach farther out are left out: the person touches the camera's plane, px."""
FALL = 2.4
"""Distance at which the lamp is as bright as LAMP says, m."""


@dataclass(frozen=True, eq=False)
class Patches:
    """The faces of one surface that a camera sees, from far to near.

    polygon: (K, 4, 2) as OpenCV draws them; face: (K,) their numbers; window: x0, y0, x1, y1 around them, px,
    which may lie outside of the picture.
    """

    polygon: Array
    face: Array
    window: tuple[int, int, int, int]

    def shifted(self, columns: int) -> Patches:
        """The same faces `columns` px further right."""
        x0, y0, x1, y1 = self.window
        polygon = self.polygon + np.array([columns << SUBPIXEL, 0], np.int32)
        return Patches(polygon, self.face, (x0 + columns, y0, x1 + columns, y1))


def patches(camera: Camera, vertex: Array, face: Array) -> Patches:
    """Cull, project and sort. vertex: (V, 3) m; face: (F, 4).

    A surface across the seam of a panorama is drawn on the side of its first vertex.
    """
    quad = vertex[face]
    middle = quad.mean(axis=1)
    toward = camera.center - middle
    shown = np.einsum("ij,ij->i", _normals(quad), toward) > 0
    pixel = project(camera, vertex)
    if camera.model == "cylinder":
        pixel[:, 0] = unwrapped(camera, pixel[:, 0])
    usable = np.abs(pixel).max(axis=1) < FARTHEST
    shown &= usable[face].all(axis=1)
    found = np.flatnonzero(shown)
    order = found[np.argsort(-np.einsum("ij,ij->i", toward[found], toward[found]), kind="stable")]
    polygon = pixel[face[order]]
    if not len(order):
        return Patches(np.empty((0, 4, 2), np.int32), order, (0, 0, 0, 0))
    x0, y0 = np.floor(polygon.min(axis=(0, 1))).astype(int).tolist()
    x1, y1 = np.ceil(polygon.max(axis=(0, 1))).astype(int).tolist()
    return Patches(fixed_point(polygon), order, (x0 - 1, y0 - 1, x1 + 2, y1 + 2))


def unwrapped(camera: Camera, column: Array) -> Array:
    """Columns of a panorama, px, moved by full turns so that they are near the first."""
    turn = 2 * np.pi * camera.matrix[0, 0]
    return np.asarray(column - turn * np.round((column - column[0]) / turn))


def in_picture(camera: Camera, seen: Patches) -> Iterator[Patches]:
    """The faces wherever they are in the picture: on a panorama also a turn further."""
    turn = round(2 * np.pi * camera.matrix[0, 0])
    for columns in (-turn, 0, turn) if camera.model == "cylinder" else (0,):
        placed = seen.shifted(columns)
        x0, y0, x1, y1 = placed.window
        if x0 < camera.size[0] and x1 > 0 and y0 < camera.size[1] and y1 > 0:
            yield placed


def clipped(window: tuple[int, int, int, int], shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Rows and columns of a window that are in a picture of that shape."""
    x0, y0, x1, y1 = window
    return slice(max(y0, 0), max(min(y1, shape[0]), 0)), slice(max(x0, 0), max(min(x1, shape[1]), 0))


def shade(quad: Array, color: Array, lamp: Array) -> Array:
    """The shaded colours of faces in the light of the room, (F, 3), 0 to 255.

    quad: (F, 4, 3) m; color: (F, 3); lamp: (3,) m.
    """
    normal = _normals(quad)
    to_lamp = lamp - quad.mean(axis=1)
    distance = np.sqrt(np.einsum("ij,ij->i", to_lamp, to_lamp))
    slant = np.maximum(np.einsum("ij,ij->i", normal, to_lamp) / distance, 0.0)
    light = AMBIENT + FROM_ABOVE * normal[:, 2] + LAMP * slant * (FALL / distance).clip(0.4, 1.5)
    return np.asarray((color * light[:, None]).clip(0, 255))


def fill_patches(image: Array, polygon: Array, tones: list[list[float]]) -> None:
    """Paint faces over a picture. polygon: (K, 4, 2) as `Patches` has them; tones: one a face."""
    for corners, tone in zip(polygon, tones, strict=True):
        cv2.fillConvexPoly(image, corners, tone, cv2.LINE_8, SUBPIXEL)


def _normals(quad: Array) -> Array:
    """Outward unit normals, (F, 3)."""
    ax, ay, az = (quad[:, 2] - quad[:, 0]).T
    bx, by, bz = (quad[:, 3] - quad[:, 1]).T
    normal = np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)
    length = np.sqrt(np.einsum("ij,ij->i", normal, normal))
    return np.asarray(normal / np.maximum(length, 1e-12)[:, None])
