"""Which pictures of different cameras belong to one moment, after caliscope's timestamps.csv."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from followspot.errors import InputError
from followspot.files import DATA, open_text

NEEDED = ("sync_index", "cam_id", "frame_index")

Moments = Mapping[str, Mapping[int, int]]
"""Camera -> number of a picture in its recording -> number of the moment."""


def read_timestamps(path: Path, cameras: Sequence[str]) -> Moments:
    """Moments of the pictures of each camera. Raises InputError.

    A line stands for one recorded picture, so the k-th line of a camera is the k-th picture of its recording,
    whatever its frame_index counts from. cam_id: a camera's name, or N for cam_N.
    """
    rows: dict[str, list[tuple[int, int]]] = {camera: [] for camera in cameras}
    for number, line in enumerate(_lines(path), 2):
        camera = _camera(line.get("cam_id") or "", cameras)
        if camera is not None:
            rows[camera].append(
                (_whole(line, "frame_index", path, number), _whole(line, "sync_index", path, number))
            )
    missing = [camera for camera, found in rows.items() if not found]
    if missing:
        raise _wrong(f"{path} has no line of camera {missing[0]}", "cam_id is its name, or N for cam_N")
    return {
        camera: {picture: moment for picture, (_, moment) in enumerate(sorted(found))}
        for camera, found in rows.items()
    }


def _lines(path: Path) -> list[dict[str, str | None]]:
    try:
        with open_text(path, DATA) as file:
            reader = csv.DictReader(file)
            absent = [name for name in NEEDED if name not in (reader.fieldnames or ())]
            if absent:
                raise _wrong(f"{path} has no column {absent[0]}", f"needs {', '.join(NEEDED)}")
            return list(reader)
    except OSError as error:
        raise _wrong(f"{path} cannot be read: {error.strerror}", "check the path") from None
    except (UnicodeDecodeError, csv.Error):
        raise _wrong(f"{path} is no CSV file", f"needs {', '.join(NEEDED)}") from None


def _camera(text: str, cameras: Sequence[str]) -> str | None:
    """The camera that an id means; None for one that is not wanted."""
    return next((name for name in (text, f"cam_{text}", f"cam{text}") if name in cameras), None)


def _whole(line: Mapping[str, str | None], column: str, path: Path, number: int) -> int:
    text = line.get(column) or ""
    if not text.isdecimal() or len(text) > 15:
        raise _wrong(f"{path}:{number}: {column} is {text!r}, not a whole number", "mend or remove the line")
    return int(text)


def _wrong(text: str, remedy: str) -> InputError:
    return InputError.of(text, remedy)
