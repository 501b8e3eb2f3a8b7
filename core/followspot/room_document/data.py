"""A room as JSON types and back: the content of its file, and what processes send each other."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from followspot.errors import Place
from followspot.room import Camera, Room, Sensor, StageUse, Sync, Tags, Target
from followspot.room_document.room import room_of
from followspot.yaml.node import node_of


def to_data(room: Room) -> dict[str, Any]:
    """The room in JSON types: the content of its file, and the folder of each source."""
    data: dict[str, Any] = {
        "room": room.name,
        "cameras": {name: _camera_data(camera) for name, camera in room.cameras.items()},
        "sensors": {name: _sensor_data(sensor) for name, sensor in room.sensors.items()},
        "planes": {name: plane.tolist() for name, plane in room.planes.items()},
        "targets": {name: _target_data(target) for name, target in room.targets.items()},
    }
    if room.truth is not None:
        data["truth"] = _use_data(room.truth)
    if room.tune:
        data["tune"] = dict(room.tune)
    if room.sync is not None:
        data["sync"] = _sync_data(room.sync)
    return data


def from_data(data: Any) -> Room:
    """The room from the result of `to_data`, checked like a file. Raises InputError."""
    return room_of(node_of(data, Place("room data", 1, 1)), None)


def _camera_data(camera: Camera) -> dict[str, Any]:
    data: dict[str, Any] = {
        "kind": camera.kind,
        "size": list(camera.size),
        "model": camera.model,
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "rotation": camera.rotation.tolist(),
        "translation": camera.translation.tolist(),
    }
    if camera.source is not None:
        data["source"] = _use_data(camera.source)
    if camera.host:
        data["host"] = camera.host
    if camera.clock_offset:
        data["clock_offset"] = float(camera.clock_offset)
    return data | _tags_data(camera.tags)


def _sensor_data(sensor: Sensor) -> dict[str, Any]:
    data: dict[str, Any] = {"kind": sensor.kind}
    if sensor.source is not None:
        data["source"] = _use_data(sensor.source)
    if sensor.rate is not None:
        data["rate"] = float(sensor.rate)
    if sensor.mount is not None:
        data["mount"] = {sensor.mount.noun: sensor.mount.name}
    if sensor.host:
        data["host"] = sensor.host
    return data | _tags_data(sensor.tags)


def _tags_data(tags: Tags) -> dict[str, Any]:
    """The tags; a single value stands alone."""
    data = {tag: values[0] if len(values) == 1 else list(values) for tag, values in tags.items()}
    return {"tags": data} if data else {}


def _target_data(target: Target) -> dict[str, Any]:
    sections: dict[str, dict[str, list[float]]] = {
        "hue_histogram": {camera: bins.tolist() for camera, bins in target.hue_histogram.items()},
        "area": {camera: [float(x) for x in limits] for camera, limits in target.area.items()},
        "gray": {camera: [float(x) for x in limits] for camera, limits in target.gray.items()},
    }
    given = {key: value for key, value in sections.items() if value}
    return {"radius": float(target.radius), **given, **_tags_data(target.tags)}


def _use_data(use: StageUse) -> dict[str, Any]:
    return {"uses": use.uses, **({"with": dict(use.params)} if use.params else {}), "folder": use.folder}


def _sync_data(sync: Sync) -> dict[str, Any]:
    """The trigger, and the other settings that differ from their defaults."""
    usual = Sync(sync.trigger)
    said = {key: value for key, value in asdict(sync).items() if value != getattr(usual, key)}
    return {"trigger": sync.trigger, **said}
