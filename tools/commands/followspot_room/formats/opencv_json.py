"""Calibrations in JSON after OpenCV's convention: cameras with K, dist, R, t (m) and planes in metres."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.room import Camera
from followspot_room.checks import (
    Unfit,
    array,
    camera_matrix,
    lens,
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
    """JSON whose cameras have K, R and t unless they are lenses alone, and a name, or a number `camera`."""
    document = json_object(files)
    listed = document.get("cameras")
    if not isinstance(listed, list) or not listed:
        return None
    if not all(isinstance(one, dict) and "K" in one for one in listed):
        return None
    cameras = [_camera(one, f"cameras[{number}]") for number, one in enumerate(listed)]
    return Calibration(unique(cameras), _planes(document), _ball_radius(document))


def json_object(files: Texts) -> Mapping[str, Any]:
    """The object in a single file of JSON; empty if it is anything else."""
    found = only_text(files)
    try:
        document = json.loads(found[1]) if found else None
    except (ValueError, RecursionError):
        return {}
    return document if isinstance(document, dict) else {}


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
    given = one.get("name", one.get("camera"))
    called = name(str(given) if type(given) is int else given, where)
    kind = KINDS.get(str(one.get("kind", "color")).lower())
    if kind is None:
        raise Unfit(f"camera {called} has kind {one['kind']!r}, known: {', '.join(KINDS)}")
    return pinhole(one, called, kind)


def pinhole(one: Mapping[str, Any], called: str, kind: str = "color") -> Camera:
    """The camera of an object with width, height, K, dist if its lens distorts, R and t. Raises Unfit.

    Without R and t it stands at the origin.
    """
    where = f"camera {called}"
    if ("R" in one) != ("t" in one):
        has, lacks = ("R", "t") if "R" in one else ("t", "R")
        raise Unfit(f"{where} has {has} but no {lacks}", "a pose is both, a lens alone has neither")
    model, coefficients = lens(one.get("dist", []), "pinhole", f"{where}: dist")
    return Camera(
        name=called,
        kind=kind,
        size=size(one, where),
        matrix=camera_matrix(one["K"], f"{where}: K"),
        distortion=coefficients,
        rotation=rotation(one.get("R", np.eye(3)), f"{where}: R"),
        translation=array(one.get("t", np.zeros(3)), (3,), f"{where}: t"),
        model=model,
    )


def size(one: Mapping[str, Any], where: str) -> tuple[int, int]:
    """Width and height, px. Raises Unfit."""
    return side(one.get("width"), f"{where}: width"), side(one.get("height"), f"{where}: height")


FORMAT = Format("json", 'JSON with "cameras" that have K, dist, and R and t if known (as OpenCV)', parse)
