"""Cameras in sight as entries of a room file, which `followspot calibrate` completes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from followspot.room import Camera, StageUse
from followspot_cameras.genicam.camera import CameraInfo
from followspot_cameras.genicam.facts import Facts

FIELD = np.radians(60.0)
"""Horizontal field of view that a lens is given before it is calibrated, rad."""
USES = "cameras.genicam"


def entries(found: Sequence[tuple[CameraInfo, Facts]], known: Mapping[str, Camera]) -> dict[str, Camera]:
    """The cameras of a room with those in sight that it lacks: at the origin, with a lens of 60 degrees.

    A camera of the room is known by the word with which its source names it.
    """
    room = dict(known)
    named = {camera.source.params.get("camera") for camera in known.values() if camera.source}
    for info, told in found:
        if named.isdisjoint(info.words) and not told.problem:
            name = _name(info, room)
            room[name] = _entry(name, info, told)
    return room


def _name(info: CameraInfo, taken: Mapping[str, Camera]) -> str:
    """The name that its user gave the camera, else one of its serial number; none that is taken."""
    word = re.sub(r"[^A-Za-z0-9_-]+", "_", info.name or f"cam{info.serial or info.address}").strip("_")
    number, name = 1, word
    while name in taken:
        number += 1
        name = f"{word}_{number}"
    return name


def _entry(name: str, info: CameraInfo, told: Facts) -> Camera:
    width, height = told.size
    focal = width / 2 / np.tan(FIELD / 2)
    matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]]).round(3)
    kind = "infrared" if told.format.startswith("Mono") else "color"
    source = StageUse(USES, {"camera": info.serial or info.address})
    return Camera(name, kind, told.size, matrix, np.zeros(5), np.eye(3), np.zeros(3), source=source)
