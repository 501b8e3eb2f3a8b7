"""Calibrations in JSON after OpenCV's convention: cameras with K, dist, R, t (m) and planes in metres."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from followspot.messages import Array
from followspot.room import Camera
from followspot_room.checks import (
    Unfit,
    array,
    camera_matrix,
    distortion,
    name,
    plane,
    rotation,
    side,
    unique,
)
from followspot_room.format import Calibration, Format, Texts, only_text

KINDS: Mapping[str, str] = {
    "color": "color",
    "colour": "color",
    "rgb": "color",
    "ir": "infrared",
    "infrared": "infrared",
}


def parse(files: Texts) -> Calibration | None:
    """JSON whose cameras have K, R and t."""
    found = only_text(files)
    document = recognise(found[1]) if found else None
    if document is None:
        return None
    cameras = [_camera(one, f"cameras[{number}]") for number, one in enumerate(document["cameras"])]
    return Calibration(unique(cameras), _planes(document), _ball_radius(document))


def recognise(text: str) -> Mapping[str, Any] | None:
    """The document, if it is JSON whose cameras have K, R and t; else None."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    listed = document.get("cameras") if isinstance(document, dict) else None
    if not isinstance(listed, list) or not listed:
        return None
    alike = all(isinstance(one, dict) and {"K", "R", "t"} <= one.keys() for one in listed)
    return document if alike else None


def _planes(document: Mapping[str, Any]) -> dict[str, Array]:
    found = document.get("planes", {})
    if not isinstance(found, dict):
        raise Unfit("planes is not a mapping of names to [a, b, c, d]")
    return {
        name(key, "planes"): plane(
            value.get("metres") if isinstance(value, dict) else value, f"planes.{key} (metres)"
        )
        for key, value in found.items()
    }


def _ball_radius(document: Mapping[str, Any]) -> float | None:
    value = document.get("ball_radius_m")
    return None if value is None else float(array(value, (), "ball_radius_m"))


def _camera(one: Mapping[str, Any], where: str) -> Camera:
    called = name(one.get("name"), where)
    where = f"camera {called}"
    kind = KINDS.get(str(one.get("kind", "color")).lower())
    if kind is None:
        raise Unfit(f"{where} has kind {one['kind']!r}, known: {', '.join(KINDS)}")
    return Camera(
        name=called,
        kind=kind,
        size=(side(one.get("width"), f"{where}: width"), side(one.get("height"), f"{where}: height")),
        matrix=camera_matrix(one["K"], f"{where}: K"),
        distortion=distortion(one.get("dist", []), "pinhole", f"{where}: dist"),
        rotation=rotation(one["R"], f"{where}: R"),
        translation=array(one["t"], (3,), f"{where}: t"),
    )


FORMAT = Format("json", 'JSON with "cameras" that have K, dist, R and t (OpenCV convention)', parse)
