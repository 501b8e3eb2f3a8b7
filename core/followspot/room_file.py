"""Room files: read with every mistake at its place, written for people to read.

A written room is read back bit for bit. A file is replaced as a whole, so a crash leaves the old one.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from followspot.errors import InputError
from followspot.files import DOCUMENT, read_text
from followspot.messages import Array
from followspot.room import Camera, Room, Target
from followspot.room_document.data import to_data
from followspot.room_document.room import room_of
from followspot.room_document.text import dump
from followspot.yaml.node import Node, plain
from followspot.yaml.reader import parse, read


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
