"""`followspot room export`."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from followspot.errors import InputError, require_unused, writing
from followspot.room import Camera, Room
from followspot.room_file import load
from followspot_room.calibration import FORMATS
from followspot_room.checks import Unfit
from followspot_room.format import Format, Texts

WRITABLE = {known.key: known for known in FORMATS if known.write is not None}
ENDINGS = {
    "camera_array.toml": "caliscope",
    ".toml": "anipose",
    ".qca.txt": "qualisys",
    ".yml": "opencv",
    ".yaml": "opencv",
}
"""Formats that the name of the output gives away, in the order in which they are tried."""


def export_room(room_file: Path, output: Path, format_key: str | None, *, as_json: bool) -> int:
    """Write the cameras of a room; returns the exit code. Raises InputError, FollowspotError."""
    chosen = WRITABLE[format_key or format_of(output)]
    room = load(room_file)
    if not room.cameras:
        raise InputError.of(f"{room_file} has no cameras", "import or calibrate them first")
    written = write_calibration(list(room.cameras.values()), output, chosen)
    if left_out := _left_out(room, chosen):
        print(f"warning: {' and '.join(left_out)} have no place in {chosen.name}", file=sys.stderr)
    if as_json:
        print(json.dumps({"format": chosen.key, "cameras": list(room.cameras), "files": written}))
    else:
        print(f"{output}: {len(room.cameras)} cameras as {chosen.name}")
    return 0


def _left_out(room: Room, chosen: Format) -> list[str]:
    """Names of the parts of the room that the format cannot hold."""
    kinds = {camera.kind for camera in room.cameras.values()} - {"color"}
    parts = {
        "planes": room.planes,
        "targets": room.targets,
        "kinds of cameras": kinds - {"infrared"} if chosen.infrared else kinds,
        "clock offsets": any(camera.clock_offset for camera in room.cameras.values()),
    }
    return [name for name, there in parts.items() if there]


def format_of(output: Path) -> str:
    """The format of the output's name. Raises InputError if it has none."""
    for ending, key in ENDINGS.items():
        if output.name.lower().endswith(ending):
            return key
    text = f"the name {output.name} does not say the format"
    raise InputError.of(text, f"give --format {'|'.join(WRITABLE)}")


def write_calibration(cameras: Sequence[Camera], output: Path, chosen: Format) -> list[str]:
    """Write a file, or the files of a folder; returns their names. Raises InputError, FollowspotError."""
    assert chosen.write is not None
    try:
        files = chosen.write(cameras)
    except Unfit as mistake:
        raise InputError.of(str(mistake), mistake.remedy) from None
    for path in [output / name for name in files] if chosen.folder else [output]:
        require_unused(path)
    with writing(output):
        return _write_folder(files, output) if chosen.folder else _write_file(files, output)


def _write_folder(files: Texts, output: Path) -> list[str]:
    output.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (output / name).write_text(text, encoding="utf-8")
    return [str(output / name) for name in files]


def _write_file(files: Texts, output: Path) -> list[str]:
    output.parent.mkdir(parents=True, exist_ok=True)
    (text,) = files.values()
    output.write_text(text, encoding="utf-8")
    return [str(output)]
