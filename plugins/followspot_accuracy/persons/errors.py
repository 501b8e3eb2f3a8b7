"""Differences between poses and true poses, as they are seen from the viewpoint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from followspot.geometry import direction, wrap
from followspot.messages import Array


@dataclass(frozen=True, eq=False)
class PoseErrors:
    """Reported minus true, K each; angles in rad from -pi to pi.

    direction: rad; distance, height: m; position: distance on the floor, m; torso: heading of the chest in
    the room; pan, tilt: of the head relative to the chest.
    """

    direction: Array
    distance: Array
    height: Array
    position: Array
    torso: Array
    pan: Array
    tilt: Array


def pose_errors(pose: Array, true: Array, viewpoint: Array) -> PoseErrors:
    """pose, true: (K, 6); viewpoint: (2,) m."""
    offset, true_offset = pose[:, :2] - viewpoint, true[:, :2] - viewpoint
    difference = pose - true
    torso, pan, tilt = wrap(difference[:, 3:]).T
    return PoseErrors(
        direction=wrap(direction(offset) - direction(true_offset)),
        distance=np.linalg.norm(offset, axis=1) - np.linalg.norm(true_offset, axis=1),
        height=difference[:, 2],
        position=np.linalg.norm(difference[:, :2], axis=1),
        torso=torso,
        pan=pan,
        tilt=tilt,
    )


def together(parts: Sequence[PoseErrors]) -> PoseErrors:
    """All of them as one."""

    def joined(name: str) -> Array:
        return np.concatenate([np.zeros(0), *(getattr(part, name) for part in parts)])

    return PoseErrors(**{field.name: joined(field.name) for field in fields(PoseErrors)})
