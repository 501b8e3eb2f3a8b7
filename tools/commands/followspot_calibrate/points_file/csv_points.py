"""Points from lines `frame,camera,u,v` or `frame,camera,u,v,point`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.csv_rows import Row, read_rows
from followspot.errors import InputError
from followspot.files import open_text
from followspot.valid_values.names import is_name
from followspot_calibrate.points_file.naming import sizes_of
from followspot_calibrate.sightings import Sightings

COLUMNS = ("frame", "camera", "u", "v")
LABEL = "point"
"""Optional column: which point of the object it is, from 0."""
LARGEST = 1 << 53
"""Whole numbers up to this are exact."""


def read_csv(path: Path, cameras: Sequence[Camera], size: tuple[int, int] | None) -> Sightings:
    """One line per point and camera that saw it; a camera is named or numbered, in the order of the room.

    Raises InputError with the line.
    """
    columns = (*COLUMNS, LABEL) if LABEL in _head(path) else COLUMNS
    numbers = _numbered(cameras)
    found: dict[tuple[int, int], dict[str, list[float]]] = {}
    for row in read_rows(path, columns):
        moment = _whole(row, "frame"), _whole(row, LABEL) if LABEL in columns else 0
        name = _camera(row, numbers)
        views = found.setdefault(moment, {})
        if name in views:
            raise row.mistake("camera", "each camera once per frame and point")
        views[name] = row.numbers("u", "v")
    if not found:
        raise InputError.of(f"{path} has no points", f"needs lines {','.join(COLUMNS)}")
    names = tuple(c.name for c in cameras) or tuple(sorted({n for views in found.values() for n in views}))
    place = {name: number for number, name in enumerate(names)}
    moments = sorted(found)
    pixel = np.full((len(moments), len(names), 2), np.nan)
    for number, moment in enumerate(moments):
        for name, position in found[moment].items():
            pixel[number, place[name]] = position
    frame, label = np.array(moments).T
    return Sightings(names, sizes_of(path, names, cameras, size), frame, label, pixel)


def _head(path: Path) -> list[str]:
    try:
        with open_text(path, errors="replace") as file:
            return [cell.strip() for cell in file.readline(1000).split(",")]
    except OSError as error:
        raise InputError.of(f"{path} cannot be read: {error.strerror}") from None


def _numbered(cameras: Sequence[Camera]) -> Mapping[str, str]:
    names = {camera.name: camera.name for camera in cameras}
    return {str(number): camera.name for number, camera in enumerate(cameras)} | names


def _camera(row: Row, known: Mapping[str, str]) -> str:
    text = row.text("camera")
    if text in known:
        return known[text]
    if known:
        raise row.mistake("camera", f"a camera of the room or its number: {', '.join(known)}")
    if not is_name(text):
        raise row.mistake("camera", "a name of letters, digits, _ and -, or a number")
    return f"cam{text}" if text.isdecimal() else text


def _whole(row: Row, column: str) -> int:
    value = row.number(column)
    if not (value.is_integer() and 0 <= value < LARGEST):
        raise row.mistake(column, "a whole number from 0")
    return int(value)
