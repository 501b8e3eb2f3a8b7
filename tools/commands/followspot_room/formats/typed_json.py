"""Calibrations in JSON: cameras by name, each a pinhole camera or a panorama, as its "type" says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.room import Camera
from followspot_room.checks import Unfit, array, camera_matrix, name, unique
from followspot_room.format import Calibration, Format, Texts
from followspot_room.formats.opencv_json import json_object, pinhole, size

LEVEL = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Rotation of a camera that looks along the room's x axis, upright."""
NEEDED = {"pinhole": {"K", "R", "t"}, "cylinder": {"F", "u0", "v0", "position"}}


def parse(files: Texts) -> Calibration | None:
    """JSON whose entries all have a known type and its keys."""
    entries = json_object(files)
    known = [isinstance(entry, dict) and str(entry.get("type")) in NEEDED for entry in entries.values()]
    if not known or not all(known):
        return None
    return Calibration(unique([_camera(key, entry) for key, entry in entries.items()]))


def _camera(called: str, entry: Mapping[str, Any]) -> Camera:
    where = f"camera {name(called, 'a camera')}"
    absent = sorted(NEEDED[entry["type"]] - entry.keys())
    if absent:
        raise Unfit(f"{where} of type {entry['type']} lacks {', '.join(absent)}")
    return _panorama(called, entry, where) if entry["type"] == "cylinder" else pinhole(entry, called)


def _panorama(called: str, entry: Mapping[str, Any], where: str) -> Camera:
    """A level panorama with its middle column along the room's x axis."""
    F, u0, v0 = (float(array(entry[key], (), f"{where}: {key}")) for key in ("F", "u0", "v0"))
    return Camera(
        name=called,
        kind="color",
        size=size(entry, where),
        matrix=camera_matrix([[F, 0, u0], [0, F, v0], [0, 0, 1]], f"{where}: F"),
        distortion=np.zeros(0),
        rotation=LEVEL,
        translation=-LEVEL @ array(entry["position"], (3,), f"{where}: position") + 0.0,
        model="cylinder",
    )


FORMAT = Format("typed-json", 'JSON of cameras by name with "type": pinhole (K, R, t) or cylinder (F)', parse)
