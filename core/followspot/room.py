"""The room as data: cameras, sensors, planes and targets, in metres, z up; see `followspot.room_file`."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from followspot.messages import Array

Trigger = Literal["line", "software", "action"]
Match = Literal["number", "time"]
LensModel = Literal["pinhole", "rational", "fisheye", "cylinder"]


Tags = Mapping[str, tuple[str, ...]]
"""Free words on a camera, a sensor or a target: tag -> its values, one or more."""
SETS: Mapping[str, str] = MappingProxyType({"cameras": "camera", "sensors": "sensor", "targets": "target"})
"""The sets of a room that have members, each with the word for one of them."""


@dataclass(frozen=True)
class Member:
    """One member of a set of the room, or one value of a tag.

    set: "cameras", "sensors", "targets", or the tag; name: of the camera, sensor or target, or the value.
    """

    set: str
    name: str

    @property
    def noun(self) -> str:
        """The word for one member of the set."""
        return SETS.get(self.set, self.set)

    def __str__(self) -> str:
        return f"{self.noun} {self.name}"


@dataclass(frozen=True)
class StageUse:
    """A stage that a room names, with its parameters and the folder that paths are relative to."""

    uses: str
    params: Mapping[str, Any] = field(default_factory=dict)
    folder: str = "."


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera, OpenCV convention: x_cam = R X + t, z forward, pixel centres at integers.

    kind: a free word; those known here are color (three channels) and infrared (one).
    matrix: (3, 3) px; distortion: (5,) k1 k2 p1 p2 k3, (8,) k1 k2 p1 p2 k3 k4 k5 k6 for a rational
    lens (OpenCV), or (4,) for a fisheye; rotation: (3, 3);
    translation: (3,) m; size: width and height, px; clock_offset: time of exposure minus
    time stamp, s. Functions on cameras stand in `followspot.geometry`.
    """

    name: str
    kind: str
    size: tuple[int, int]
    matrix: Array
    distortion: Array
    rotation: Array
    translation: Array
    model: LensModel = "pinhole"
    source: StageUse | None = None
    host: str = ""
    clock_offset: float = 0.0
    tags: Tags = field(default_factory=dict)

    @cached_property
    def projection(self) -> Array:
        """P = K [R | t], (3, 4), for undistorted pixels (Hartley & Zisserman, eq. 6.8)."""
        return np.asarray(self.matrix @ np.column_stack([self.rotation, self.translation]))

    @cached_property
    def center(self) -> Array:
        """Camera centre in the room, (3,) m: C = -R^T t."""
        return np.asarray(-self.rotation.T @ self.translation)


@dataclass(frozen=True, eq=False)
class Sensor:
    """A device that is no camera.

    kind: a free word, for example imu; rate: readings a second, 1/s, None if it is not known; mount: the
    target or the camera that carries it.
    """

    name: str
    kind: str
    source: StageUse | None = None
    rate: float | None = None
    mount: Member | None = None
    host: str = ""
    tags: Tags = field(default_factory=dict)


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
    tags: Tags = field(default_factory=dict)


@dataclass(frozen=True)
class Sync:
    """How the cameras of a room are triggered together.

    trigger: "line", the leading camera triggers the others over a cable; "software", each camera is triggered
    by its own host, at moments that the hosts' clocks share; "action", the host of the leading camera sends
    action commands of GigE Vision to all at once; camera: the leading one, "" for none; rate: triggers a
    second, 0 if a line's is unknown; the keys are those of action commands; match: "number" if pictures of
    one trigger get one capture time, by their numbers, "time" if each keeps that of the camera's clock.
    """

    trigger: Trigger
    camera: str = ""
    rate: float = 0.0
    device_key: int = 1
    group_key: int = 1
    group_mask: int = 1
    match: Match = "number"


@dataclass(frozen=True, eq=False)
class Room:
    """The calibrated place. Cameras, sensors, planes and targets keep the order of the file.

    planes: name -> (4,) [a b c d], a x + b y + c z + d = 0 with unit normal, m;
    truth: a source of `followspot.tracking.Truth`, for rooms with ground truth; tune: parameters of stages
    that suit the place, by PLUGIN.STAGE.PARAMETER or STAGE.PARAMETER; sync: None if cameras run freely.
    """

    name: str = "room"
    cameras: Mapping[str, Camera] = field(default_factory=lambda: MappingProxyType({}))
    planes: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    targets: Mapping[str, Target] = field(default_factory=lambda: MappingProxyType({}))
    truth: StageUse | None = None
    sensors: Mapping[str, Sensor] = field(default_factory=lambda: MappingProxyType({}))
    tune: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    sync: Sync | None = None

    @cached_property
    def carriers(self) -> tuple[Camera | Sensor, ...]:
        """The cameras, then the sensors: whose tags group the room."""
        return (*self.cameras.values(), *self.sensors.values())

    @cached_property
    def tags(self) -> Tags:
        """Every tag of a camera or sensor, with its values in the order of the room."""
        values: dict[str, dict[str, None]] = {}
        for carrier in self.carriers:
            for tag, words in carrier.tags.items():
                values.setdefault(tag, {}).update(dict.fromkeys(words))
        return {tag: tuple(words) for tag, words in values.items()}

    @cached_property
    def carried(self) -> Mapping[tuple[str, str], Mapping[str, tuple[Member, ...]]]:
        """(set, tag) -> value of the tag -> the members of the set that carry it."""
        found: dict[tuple[str, str], dict[str, list[Member]]] = {}
        for name in SETS:
            for owner in self.members(name).values():
                for tag, values in owner.tags.items():
                    for value in values:
                        groups = found.setdefault((name, tag), {})
                        groups.setdefault(value, []).append(Member(name, owner.name))
        return {key: {v: tuple(m) for v, m in groups.items()} for key, groups in found.items()}

    def with_cameras(self, names: Collection[str] | None) -> Room:
        """The room with those of its cameras that are named, in its own order; None: all.

        The same object for the same cameras, so that stages share what they derive from it.
        """
        kept = {name: camera for name, camera in self.cameras.items() if names is None or name in names}
        if len(kept) == len(self.cameras):
            return self
        return self._parts.setdefault(tuple(kept), replace(self, cameras=kept))

    @cached_property
    def _parts(self) -> dict[tuple[str, ...], Room]:
        """The rooms of :meth:`with_cameras` by the names of their cameras."""
        return {}

    def members(self, name: str) -> Mapping[str, Camera | Sensor | Target]:
        """The members of one of `SETS` by name."""
        sets = {"cameras": self.cameras, "sensors": self.sensors, "targets": self.targets}
        return sets[name]  # type: ignore[return-value]  # mypy joins the three types
