"""The room as data: cameras, planes and targets, in metres, z up; `followspot.room_file` reads it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from followspot.messages import Array

Kind = Literal["color", "infrared", "depth"]
Model = Literal["pinhole", "fisheye", "cylinder"]


@dataclass(frozen=True)
class StageUse:
    """A stage that a room names, with its parameters and the folder that paths are relative to."""

    uses: str
    params: Mapping[str, Any] = field(default_factory=dict)
    folder: str = "."


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera, OpenCV convention: x_cam = R X + t, z forward, pixel centres at integers.

    matrix: (3, 3) px; distortion: (5,) k1 k2 p1 p2 k3, or (4,) for a fisheye; rotation: (3, 3);
    translation: (3,) m; size: width and height, px; clock_offset: time of exposure minus
    time stamp, s. Functions on cameras stand in `followspot.geometry`.
    """

    name: str
    kind: Kind
    size: tuple[int, int]
    matrix: Array
    distortion: Array
    rotation: Array
    translation: Array
    model: Model = "pinhole"
    source: StageUse | None = None
    host: str = ""
    clock_offset: float = 0.0

    @cached_property
    def projection(self) -> Array:
        """P = K [R | t], (3, 4), for undistorted pixels (Hartley & Zisserman, eq. 6.8)."""
        return np.asarray(self.matrix @ np.column_stack([self.rotation, self.translation]))

    @cached_property
    def center(self) -> Array:
        """Camera centre in the room, (3,) m: C = -R^T t."""
        return np.asarray(-self.rotation.T @ self.translation)


@dataclass(frozen=True, eq=False)
class Target:
    """An object to track and its template.

    radius: m; hue_histogram: camera -> (16,) normalised; area: camera -> smallest and largest, px;
    gray: infrared camera -> lowest and highest grey level.
    """

    name: str
    radius: float
    hue_histogram: Mapping[str, Array] = field(default_factory=dict)
    area: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    gray: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Room:
    """The calibrated place. Cameras, planes and targets keep the order of the file.

    planes: name -> (4,) [a b c d], a x + b y + c z + d = 0 with unit normal, m;
    truth: a source of `followspot.tracking.Truth`, for rooms with ground truth.
    """

    name: str = "room"
    cameras: Mapping[str, Camera] = field(default_factory=lambda: MappingProxyType({}))
    planes: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    targets: Mapping[str, Target] = field(default_factory=lambda: MappingProxyType({}))
    truth: StageUse | None = None
