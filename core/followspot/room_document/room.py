"""From a room document to a room, with every mistake at its line and column."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from followspot.errors import InputError, Mistake
from followspot.messages import Array
from followspot.room import Camera, Room
from followspot.room_document.camera import camera_of
from followspot.room_document.parts import FAR, ROUNDING, TOLERANCE, stage_use
from followspot.room_document.sensor import sensor_of
from followspot.room_document.sync import sync_of
from followspot.room_document.target import target_of
from followspot.room_document.tune import tune_of
from followspot.valid_values.names import is_name
from followspot.yaml.form import Form
from followspot.yaml.node import Node

MAX_CAMERAS = 1000
MAX_SENSORS = 1000
MAX_TARGETS = 1000
MAX_PLANES = 1000
_KEYS = ("room", "cameras", "sensors", "planes", "targets", "truth", "tune", "sync")


def room_of(root: Node, folder: str | None) -> Room:
    """The room that a document describes. Raises InputError with every mistake.

    folder: that paths in the document are relative to; None if each source has its own.
    """
    mistakes: list[Mistake] = []
    form = Form(root, "a room", _KEYS, mistakes)
    name = form.title("room") or "room"
    cameras = _cameras(form, folder)
    sensors = {
        key: sensor_of(key, node, form, folder) for key, node in _named(form, "sensors", MAX_SENSORS).items()
    }
    planes = {key: _plane(form, key, node) for key, node in _named(form, "planes", MAX_PLANES).items()}
    names = form.mapping("cameras")
    targets = {
        key: target_of(key, node, names, mistakes)
        for key, node in _named(form, "targets", MAX_TARGETS).items()
    }
    truth = form.get("truth")
    use = None if truth is None else stage_use(truth, "truth", folder, mistakes)
    tune = tune_of(form)
    sync = sync_of(form, names)
    if mistakes:
        raise InputError(mistakes)
    return Room(
        name=name,
        cameras=cameras,
        planes=planes,
        targets=targets,
        truth=use,
        sensors=sensors,
        tune=tune,
        sync=sync,
    )


def _named(form: Form, key: str, most: int) -> Mapping[str, Node]:
    """The entries of a section; notes mistakes in their names."""
    entries = form.mapping(key)
    if len(entries) > most:
        form.wrong(form.entries[key], f"{len(entries)} {key}, at most {most} are allowed")
        return {}
    for name, node in entries.items():
        if not is_name(name):
            form.mistakes.append(
                Mistake(node.key, f'"{name}" cannot be a name', "use 1 to 100 letters, digits, _ and -")
            )
    return entries


def _cameras(form: Form, folder: str | None) -> dict[str, Camera]:
    found = {
        name: camera_of(name, node, folder, form.mistakes)
        for name, node in _named(form, "cameras", MAX_CAMERAS).items()
    }
    return {name: camera for name, camera in found.items() if camera is not None}


def _plane(form: Form, name: str, node: Node) -> Array:
    """The plane, (4,), with unit normal; zeros if it cannot be read."""
    plane = form.numbers(node, f"plane {name}", [(4,)], most=FAR)
    if plane is None:
        return np.zeros(4)
    length = float(np.linalg.norm(plane[:3]))
    if abs(length - 1.0) > TOLERANCE:
        remedy = (
            "divide all four numbers by it" if length > 0 else "a x + b y + c z + d = 0 with a unit normal, m"
        )
        form.wrong(node, f"the normal of plane {name} has length {length:.6g}, not 1", remedy)
        return plane
    return plane if abs(length - 1.0) < ROUNDING else plane / length
