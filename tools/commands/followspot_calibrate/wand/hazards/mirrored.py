"""Pictures that are flipped: a mirror image has perfect epipolar lines, and no place for its camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.wand.hazards.support import CLEARLY, ENOUGH, support


@dataclass(frozen=True)
class Mirrored:
    """way: how the picture is flipped, left-right or up-down; share: of the points that fit flipped back."""

    way: str
    share: float


def mirrored(camera: Camera, points: Array, pixel: Array, others: Sequence[Camera]) -> Mirrored | None:
    """The fault if a camera sees the points of the others only in a mirror image; None if it does not.

    points: (N, 3); pixel: (N, 2) px of this camera, which has its lens and no pose yet. Left-right and
    up-down differ by half a turn of the camera: the fault names the flip that leaves it upright.
    """
    flipped = support(camera, points, left_right(camera, pixel))
    plain = support(camera, points, pixel)
    if flipped.camera is None or flipped.share < max(ENOUGH, CLEARLY * plain.share):
        return None
    down = np.mean([other.rotation[1] for other in others], axis=0)
    way = "left-right" if flipped.camera.rotation[1] @ down > 0 else "up-down"
    return Mirrored(way, flipped.share)


def left_right(camera: Camera, pixel: Array) -> Array:
    """The pixels of a picture that is flipped left to right: (N, 2) px."""
    return np.column_stack([camera.size[0] - 1 - pixel[:, 0], pixel[:, 1]])
