"""Known places from CSV files: camera centres, or points of a marker that cameras see."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot.csv_rows import Row, read_rows
from followspot.errors import InputError
from followspot.messages import Array
from followspot_calibrate.wand.alignment import Marker

MOST = 10_000
"""Lines of such a file."""


def read_centers(path: Path, cameras: Sequence[str]) -> dict[str, Array]:
    """Lines `camera,x,y,z` (m): camera -> (3,). Raises InputError with the line."""
    centers: dict[str, Array] = {}
    for row in read_rows(path, ("camera", "x", "y", "z")):
        name = _camera(row, cameras)
        if name in centers:
            raise row.mistake("camera", "each camera once")
        centers[name] = np.array(row.numbers("x", "y", "z"))
    return centers


def read_marker(path: Path, cameras: Sequence[str]) -> Marker:
    """Lines `x,y,z,camera,u,v` (m, px), one per point and camera that sees it. Raises InputError."""
    seen: dict[tuple[float, ...], Array] = {}
    for row in read_rows(path, ("x", "y", "z", "camera", "u", "v")):
        if len(seen) > MOST:
            raise row.mistake("x", f"at most {MOST} points")
        views = seen.setdefault(tuple(row.numbers("x", "y", "z")), np.full((len(cameras), 2), np.nan))
        number = cameras.index(_camera(row, cameras))
        if np.isfinite(views[number, 0]):
            raise row.mistake("camera", "each camera once per point")
        views[number] = row.numbers("u", "v")
    if not seen:
        raise InputError.of(f"{path} has no points", "needs lines x,y,z,camera,u,v")
    return Marker(np.array(list(seen)), np.array(list(seen.values())))


def _camera(row: Row, cameras: Sequence[str]) -> str:
    """A camera by its name or number."""
    text = row.text("camera")
    if text in cameras:
        return text
    if not (text.isdecimal() and int(text) < len(cameras)):
        raise row.mistake("camera", f"one of {', '.join(cameras)}, or its number from 0")
    return cameras[int(text)]
