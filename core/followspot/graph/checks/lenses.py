"""Lens models that are not one to one within the picture: parts of it have no direction of their own."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from followspot.errors import Mistake
from followspot.geometry import project_local
from followspot.lens import fold, local_rays
from followspot.room import Camera, Room
from followspot.yaml.node import Node, child

_SIDE = 17
"""Pixels that are tried along each side of a picture."""
_TOLERANCE = 0.5
"""Largest distance of a pixel from the image of its own direction, px."""
_SMALLEST = 0.01
"""Smallest part of the picture that is told."""
_REMEDY = "the order is k1, k2, p1, p2, k3; or calibrate with points in the whole picture"


def folded_lenses(room: Room, node: Node | None) -> Iterator[Mistake]:
    """A mistake for each camera whose lens model folds within its picture, at its coefficients.

    node: of the room file, None if there is none.
    """
    for camera in room.cameras.values():
        part = 1.0 - _unfolded(camera) if camera.distortion.any() else 0.0
        if part > _SMALLEST:
            at = child(child(child(node, "cameras"), camera.name), "distortion")
            text = f"the distortion of camera {camera.name} is not one to one in {part:.0%} of its picture"
            yield Mistake(None if at is None else at.place, text, _REMEDY)


def _unfolded(camera: Camera) -> float:
    """Part of the picture whose pixels are the images of their own directions, before the lens folds."""
    x, y = (np.linspace(0.0, side - 1.0, _SIDE) for side in camera.size)
    pixel = np.array(np.meshgrid(x, y)).reshape(2, -1).T
    with np.errstate(all="ignore"):
        rays = local_rays(camera, pixel)
        away = np.linalg.norm(project_local(camera, rays) - pixel, axis=1)
        across = np.hypot(rays[:, 0], rays[:, 1])
        found = (away < _TOLERANCE) & (across / fold(camera) <= np.abs(rays[:, 2]))
    return float(found.mean())
