"""Calibrations in JSON: cameras by name, each a pinhole camera or a panorama, as its "type" says."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.room import Camera
from followspot_room.checks import (
    Unfit,
    array,
    camera_matrix,
    distortion,
    name,
    rotation,
    side,
    unique,
)
from followspot_room.format import Calibration, Format, Texts, only_text

LEVEL = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Rotation of a camera that looks along the room's x axis, upright."""
NEEDED = {"pinhole": {"K", "R", "t"}, "cylinder": {"F", "u0", "v0", "position"}}


def parse(files: Texts) -> Calibration | None:
    """JSON whose entries all have a known type and its keys."""
    found = only_text(files)
    entries = recognise(found[1]) if found else None
    if entries is None:
        return None
    return Calibration(unique([_camera(key, entry) for key, entry in entries.items()]))


def recognise(text: str) -> Mapping[str, Mapping[str, Any]] | None:
    """The entries, if it is JSON of cameras by name; else None."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(document, dict) or not document:
        return None
    alike = all(isinstance(entry, dict) and str(entry.get("type")) in NEEDED for entry in document.values())
    return document if alike else None


def _camera(called: str, entry: Mapping[str, Any]) -> Camera:
    where = f"camera {name(called, 'a camera')}"
    absent = sorted(NEEDED[entry["type"]] - entry.keys())
    if absent:
        raise Unfit(f"{where} of type {entry['type']} lacks {', '.join(absent)}")
    size = (side(entry.get("width"), f"{where}: width"), side(entry.get("height"), f"{where}: height"))
    if entry["type"] == "cylinder":
        return _panorama(called, entry, where, size)
    return Camera(
        name=called,
        kind="color",
        size=size,
        matrix=camera_matrix(entry["K"], f"{where}: K"),
        distortion=distortion(entry.get("dist", []), "pinhole", f"{where}: dist"),
        rotation=rotation(entry["R"], f"{where}: R"),
        translation=array(entry["t"], (3,), f"{where}: t"),
    )


def _panorama(called: str, entry: Mapping[str, Any], where: str, size: tuple[int, int]) -> Camera:
    """A level panorama with its middle column along the room's x axis."""
    F, u0, v0 = (float(array(entry[key], (), f"{where}: {key}")) for key in ("F", "u0", "v0"))
    return Camera(
        name=called,
        kind="color",
        size=size,
        matrix=camera_matrix([[F, 0, u0], [0, F, v0], [0, 0, 1]], f"{where}: F"),
        distortion=np.zeros(0),
        rotation=LEVEL,
        translation=-LEVEL @ array(entry["position"], (3,), f"{where}: position") + 0.0,
        model="cylinder",
    )


FORMAT = Format("typed-json", 'JSON of cameras by name with "type": pinhole (K, R, t) or cylinder (F)', parse)
