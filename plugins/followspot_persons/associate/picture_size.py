"""Warning of joints that seem to be of smaller pictures than the room states: none lies far enough out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from followspot import Array, Camera

MANY = 300
"""Joints of a camera from which on it is no accident that all lie in one part of its picture."""


class Reach(NamedTuple):
    """Number of a camera's joints, and the largest of their coordinates, px."""

    joints: int = 0
    u: float = -np.inf
    v: float = -np.inf

    def beyond(self, pixel: Array) -> Reach:
        """The reach with further joints, (N, 2) px; NaN for a joint that was not found."""
        pixel = pixel[np.isfinite(pixel).all(axis=1)]
        u, v = pixel.max(axis=0, initial=-np.inf)
        return Reach(self.joints + len(pixel), max(self.u, float(u)), max(self.v, float(v)))


def picture_size_warning(reach: Mapping[str, Reach], cameras: Mapping[str, Camera]) -> str:
    """A warning that names the cameras whose joints all lie in the upper left quarter; empty if none do."""
    quarter = [
        f"{name} ({found.joints} joints up to {found.u:.0f}, {found.v:.0f} px)"
        for name, found in reach.items()
        if found.joints >= MANY
        and 2 * found.u < cameras[name].size[0]
        and 2 * found.v < cameras[name].size[1]
    ]
    if not quarter:
        return ""
    return (
        f"all joints lie in the upper left quarter of the picture of {', '.join(quarter)}: they seem to be of"
        " smaller pictures, so that people are not found; take them from pictures of the room's `size`"
    )
