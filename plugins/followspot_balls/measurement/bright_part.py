"""The share of a whole ball's outline that its blob fills."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.room import Camera, Room

PARALLEL = 1e-3
"""Smallest eigenvalue of the normal equations over the number of cameras, below which the optical axes are
parallel and meet nowhere."""


def bright_part(room: Room) -> Array:
    """Share of a whole ball's outline that its blob fills in each camera: (C,), 1 without templates.

    Reflective patches are dim towards the rim, so an infrared blob may show less of a ball than a colour
    blob. All infrared cameras have one share: the ratio of the areas in their templates to those of the
    colour cameras, at one distance.
    """
    kind = np.array([c.kind for c in room.cameras.values()])
    size, infrared = sizes(room), kind == "infrared"
    dim, whole = (np.log(size[of_kind & (size > 0)]) for of_kind in (infrared, kind == "color"))
    part = np.exp(dim.mean() - whole.mean()) if len(dim) and len(whole) else 1.0
    return np.where(infrared, part, 1.0)


def sizes(room: Room) -> Array:
    """Area of the blob of a ball of unit radius at unit distance over the squared focal length: (C,).

    NaN without a template. A template has the smallest and the largest area of a ball that moved about what
    the cameras look at. Its distance goes as the inverse root of the area, so the middle of both is as far
    as the middle of the room.
    """
    cameras = list(room.cameras.values())
    away = distances_to_middle(cameras)
    found = np.full(len(cameras), np.nan)
    for number, camera in enumerate(cameras):
        limits = [
            np.divide(t.area[camera.name], t.radius**2)
            for t in room.targets.values()
            if camera.name in t.area and min(t.area[camera.name]) > 0
        ]
        if limits:
            width = np.median(1 / (1 / np.sqrt(limits)).mean(axis=1))
            found[number] = np.square(width * away[number] / camera.matrix[0, 0])
    return found


def distances_to_middle(cameras: list[Camera]) -> Array:
    """Distances of cameras from the point nearest to all optical axes, m: (C,).

    They are 1 if the axes are parallel, or meet behind a camera.
    """
    centers = np.array([c.center for c in cameras]).reshape(-1, 3)
    axes = np.array([c.rotation[2] for c in cameras]).reshape(-1, 3)
    across = np.eye(3) - axes[:, :, None] * axes[:, None]
    normal = across.sum(axis=0)
    if np.linalg.eigvalsh(normal)[0] <= PARALLEL * len(cameras):
        return np.ones(len(cameras))
    offset = np.linalg.solve(normal, (across @ centers[..., None]).sum(axis=0))[:, 0] - centers
    if (np.vecdot(offset, axes) <= 0).any():
        return np.ones(len(cameras))
    return np.asarray(np.linalg.norm(offset, axis=1))
