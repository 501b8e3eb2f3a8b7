"""Room files: read with every mistake at its place, written for people to read.

A written room is read back bit for bit. A file is replaced as a whole, so a crash leaves the old one.
"""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from followspot.document import Node, node_of, plain
from followspot.errors import InputError, Place
from followspot.files import DOCUMENT, read_text
from followspot.messages import Array
from followspot.room import Camera, Room, Sensor, StageUse, Sync, Tags, Target
from followspot.room_form.room import room_of
from followspot.yaml_reader import parse, read
from followspot.yaml_scalars import resolve

_LINE = 100
"""Longest mapping that is written on one line, in characters."""
_PLAIN_TEXT = re.compile(r"[A-Za-z_/][A-Za-z0-9_./+-]*")
_UNPRINTABLE = re.compile(r"[\x7f-\x9f\u2028\u2029\ufeff\ud800-\udfff\ufffe\uffff]")


def load(path: str | Path) -> Room:
    """Read a room file. Raises InputError with every mistake at its line and column."""
    return room_of(read(path), str(Path(path).parent))


def save(room: Room, path: str | Path) -> None:
    """Write a room file. Paths in sources must be relative to its folder. Raises InputError, OSError."""
    _write(Path(path), dump(_without_folders(to_data(room))))


def update(
    path: str | Path,
    *,
    cameras: Mapping[str, Camera] | None = None,
    planes: Mapping[str, Array] | None = None,
    targets: Mapping[str, Target] | None = None,
) -> None:
    """Replace whole sections of a room file, all at once; every other line and comment stays as it is.

    A file that is one flow mapping, or shares anchors between sections, is rewritten without comments.
    Raises InputError if the file or the new sections are wrong, and leaves the file unchanged.
    """
    file = Path(path)
    root = read(file)
    room = Room(cameras=cameras or {}, planes=planes or {}, targets=targets or {})
    given = {"cameras": cameras, "planes": planes, "targets": targets}
    data = _without_folders(to_data(room))
    sections = {key: data.get(key, {}) for key, value in given.items() if value is not None}
    entries = root.value if isinstance(root.value, Mapping) else {}
    wanted = {**plain(root), **sections} if isinstance(root.value, Mapping) else plain(root)
    text = read_text(file, DOCUMENT)
    line_end = "\r\n" if "\r\n" in text else "\n"
    # From the last section to the first, so that line numbers of the others stay valid.
    for key in sorted(sections, key=lambda key: entries[key].key.line if key in entries else 0, reverse=True):
        text = _spliced(text, entries, key, dump({key: sections[key]}).replace("\n", line_end))
    if not _says(text, wanted):
        text = dump(wanted).replace("\n", line_end)
    _write(file, text)


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


def _sync_data(sync: Sync) -> dict[str, Any]:
    """The trigger, and the other settings that differ from their defaults."""
    usual = Sync(sync.trigger)
    said = {key: value for key, value in asdict(sync).items() if value != getattr(usual, key)}
    return {"trigger": sync.trigger, **said}


def from_data(data: Any) -> Room:
    """The room from the result of `to_data`, checked like a file. Raises InputError."""
    return room_of(node_of(data, Place("room data", 1, 1)), None)


def dump(data: Mapping[str, Any], indent: int = 0) -> str:
    """YAML: short mappings and lists of numbers on one line, matrices one row a line."""
    lines: list[str] = []
    pad = " " * indent
    for key, value in data.items():
        label, flow = f"{pad}{_flow(str(key))}:", _flow(value)
        if _is_matrix(value):
            lines += [f"{label}\n", *(f"{pad}  - {_flow(row)}\n" for row in value)]
        elif isinstance(value, Mapping) and value and (len(label) + len(flow) > _LINE or _nests(value)):
            lines += [f"{label}\n", dump(value, indent + 2)]
        else:
            lines.append(f"{label} {flow}\n")
    return "".join(lines)


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


def _without_folders(data: dict[str, Any]) -> dict[str, Any]:
    """A room without the folders of its sources, for a file: its own folder replaces them."""
    parts = [part for key in ("cameras", "sensors") for part in data[key].values()]
    for use in [*(part.get("source") for part in parts), data.get("truth")]:
        if use is not None:
            del use["folder"]
    return {key: value for key, value in data.items() if value}


def _spliced(text: str, entries: Mapping[str, Node], key: str, section: str) -> str:
    """The text with the lines of one section replaced; appended if the text has no such section."""
    lines = text.splitlines(keepends=True)
    if key not in entries:
        return text + ("" if not text or text.endswith("\n") else "\n") + section
    start = entries[key].key.line - 1
    following = [node.key.line - 1 for node in entries.values() if node.key.line - 1 > start]
    end = min(following, default=len(lines))
    while end - 1 > start and (not lines[end - 1].strip() or lines[end - 1].startswith("#")):
        end -= 1  # comments above the next key belong to it
    return "".join([*lines[:start], section, *lines[end:]])


def _says(text: str, wanted: Any) -> bool:
    try:
        return bool(plain(parse(text, "")) == wanted)
    except InputError:
        return False


def _write(path: Path, text: str) -> None:
    """Check the text as a room, write it beside the file, then replace the file, which a link may name."""
    room_of(parse(text, f"{path} (as it would be)"), str(path.parent))
    path = Path(os.path.realpath(path))
    mode = path.stat().st_mode & 0o777 if path.exists() else 0o644
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as stream:
            stream.write(text)
        Path(temporary).chmod(mode)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _is_matrix(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, list) for row in value)


def _nests(value: Mapping[str, Any]) -> bool:
    return any(_is_matrix(child) or isinstance(child, Mapping) for child in value.values())


def _flow(value: Any) -> str:
    """A value on one line; floats keep every bit."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_flow(str(k))}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    if isinstance(value, float):
        text = repr(value)
        # YAML 1.1 readers parse 1e-05 as a text.
        return text if "." in text or "e" not in text else text.replace("e", ".0e")
    if isinstance(value, str):
        return value if _PLAIN_TEXT.fullmatch(value) and resolve(value) == value else _quoted(value)
    return json.dumps(value)


def _quoted(text: str) -> str:
    return _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", json.dumps(text, ensure_ascii=False))
