"""`followspot cameras`: the machine-vision cameras in sight, as a table, as JSON, or into a room file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from followspot import room_file
from followspot.errors import writing
from followspot.room import Room
from followspot.tables.terminal import table
from followspot_cameras.genicam.backends import BackendName, backend, discovered
from followspot_cameras.genicam.camera import CameraInfo
from followspot_cameras.genicam.facts import Facts, facts
from followspot_cameras.genicam.room_entries import entries

Found = Sequence[tuple[CameraInfo, Facts]]
NONE = (
    "no camera is in sight; is it switched on and on this network, with an address of it, and is UDP port "
    "3956 free of firewalls?"
)


def cameras(name: BackendName, interface: str, timeout: float, output: Path | None, *, as_json: bool) -> int:
    """List the cameras; output: the room file to write. Returns the exit code, 1 if none is in sight."""
    found = [(info, _facts(info)) for info in discovered(name, interface, timeout)]
    added = _written(found, output) if output is not None and found else []
    print(
        json.dumps({"cameras": [_data(*one) for one in found], "added": added}) if as_json else _text(found)
    )
    if not as_json and output is not None:
        print(f"{output}: added {', '.join(added) or 'nothing'}" if found else f"{output} was not written")
        if added:
            print(
                "they stand at the origin and have lenses of 60 degrees: calibrate them (docs/calibration.md)"
            )
    return 0 if found else 1


def _facts(info: CameraInfo) -> Facts:
    module = backend(info.backend)
    assert module is not None, "it found the camera"
    return facts(info, module)


def _data(info: CameraInfo, told: Facts) -> dict[str, Any]:
    words = {name: getattr(info, name) for name in ("backend", "transport", "address", "vendor", "model")}
    return {**words, "serial": info.serial, "name": info.name, **asdict(told)}


def _text(found: Found) -> str:
    if not found:
        return NONE
    head = ("camera", "serial", "name", "address", "by", "picture", "format", "1/s", "clock")
    return table(head, [_row(*one) for one in found])


def _row(info: CameraInfo, told: Facts) -> tuple[str, ...]:
    words = (f"{info.vendor} {info.model}".strip(), info.serial, info.name, info.address, info.backend)
    if told.problem:
        return (*words, told.problem[:60], "", "", "")
    rate = "" if told.rate is None else f"{told.rate:g}"
    return (*words, "x".join(map(str, told.size)), told.format, rate, told.time)


def _written(found: Found, output: Path) -> list[str]:
    """Names of the cameras that were added to a room file, which is made if it is not there."""
    if output.exists():
        known = room_file.load(output).cameras
        room = entries(found, known)
        if len(room) > len(known):
            room_file.update(output, cameras=room)
    else:
        known, room = {}, entries(found, {})
        with writing(output):
            output.parent.mkdir(parents=True, exist_ok=True)
            room_file.save(Room(name=output.stem, cameras=room), output)
    return [name for name in room if name not in known]
