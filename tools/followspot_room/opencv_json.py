"""Calibrations in JSON after OpenCV's convention: cameras with K, dist, R, t (m) and planes in metres."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.room import Camera, Kind
from followspot_room.checks import Unfit, array, plane, rotation

KINDS: Mapping[str, Kind] = {
    "color": "color",
    "colour": "color",
    "rgb": "color",
    "ir": "infrared",
    "infrared": "infrared",
}
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
MOST_CAMERAS = 1000
LARGEST_SIDE = 1 << 15
"""px"""


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


def cameras(document: Mapping[str, Any]) -> tuple[Camera, ...]:
    """All cameras. Raises Unfit for the first mistake."""
    listed = document["cameras"]
    if len(listed) > MOST_CAMERAS:
        raise Unfit(f"{len(listed)} cameras, at most {MOST_CAMERAS}")
    found = tuple(_camera(one, f"cameras[{number}]") for number, one in enumerate(listed))
    names = [camera.name for camera in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise Unfit(f"camera {twice[0]} is there twice")
    return found


def planes(document: Mapping[str, Any]) -> dict[str, Array]:
    """Planes by name, in metres. Raises Unfit."""
    found = document.get("planes", {})
    if not isinstance(found, dict):
        raise Unfit("planes is not a mapping of names to [a, b, c, d]")
    return {
        _name(name, "planes"): plane(
            value.get("metres") if isinstance(value, dict) else value, f"planes.{name} (metres)"
        )
        for name, value in found.items()
    }


def ball_radius(document: Mapping[str, Any]) -> float | None:
    """Radius of the targets, m, where the file knows it. Raises Unfit."""
    value = document.get("ball_radius_m")
    return None if value is None else float(array(value, (), "ball_radius_m"))


def _camera(one: Mapping[str, Any], where: str) -> Camera:
    name = _name(one.get("name"), where)
    where = f"camera {name}"
    kind = KINDS.get(str(one.get("kind", "color")).lower())
    if kind is None:
        raise Unfit(f"{where} has kind {one['kind']!r}, known: {', '.join(KINDS)}")
    return Camera(
        name=name,
        kind=kind,
        size=(_side(one, "width", where), _side(one, "height", where)),
        matrix=_matrix(one["K"], f"{where}: K"),
        distortion=_distortion(one.get("dist", []), f"{where}: dist"),
        rotation=rotation(one["R"], f"{where}: R"),
        translation=array(one["t"], (3,), f"{where}: t"),
    )


def _name(value: Any, where: str) -> str:
    if not isinstance(value, str) or not NAME.fullmatch(value):
        raise Unfit(f"{where} has the name {value!r}; needs letters, digits, _ . -")
    return value


def _side(one: Mapping[str, Any], key: str, where: str) -> int:
    value = one.get(key)
    if type(value) is not int or not 0 < value <= LARGEST_SIDE:
        raise Unfit(f"{where}: {key} is {value!r}, needs a number of pixels")
    return value


def _matrix(value: Any, where: str) -> Array:
    K = array(value, (3, 3), where)
    if K[0, 0] <= 0 or K[1, 1] <= 0 or K[1, 0] or list(K[2]) != [0, 0, 1]:
        raise Unfit(f"{where} is no camera matrix [[fx, s, cx], [0, fy, cy], [0, 0, 1]]")
    return K


def _distortion(value: Any, where: str) -> Array:
    """k1 k2 p1 p2 k3; shorter lists of OpenCV end with zeros."""
    if not isinstance(value, list) or len(value) not in (0, 4, 5):
        raise Unfit(f"{where} needs k1, k2, p1, p2 and k3")
    return np.concatenate([array(value, (len(value),), where), np.zeros(5 - len(value))])
