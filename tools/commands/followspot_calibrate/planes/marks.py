"""Points on planes as cameras saw them, from a CSV file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.csv_rows import Row, read_rows
from followspot.errors import InputError
from followspot.valid_values.names import is_name
from followspot_calibrate.sightings import Sightings

COLUMNS = ("plane", "point", "camera", "u", "v")
MOST_POINTS = 1_000_000

Marks = Mapping[str, Sightings]
"""Plane -> the points on it; `frame` is the number of the point in order of appearance."""


def read_marks(path: Path, cameras: Sequence[Camera]) -> Marks:
    """Points on planes from lines `plane,point,camera,u,v`; lines with one plane and point correspond.

    A camera is named, or numbered in the order of the room from 0. Raises InputError with the line.
    """
    names = {camera.name: number for number, camera in enumerate(cameras)}
    names |= {str(number): number for number in range(len(cameras)) if str(number) not in names}
    found: dict[str, dict[str, dict[int, list[float]]]] = {}
    for count, row in enumerate(read_rows(path, COLUMNS)):
        if count >= MOST_POINTS:
            raise row.mistake("plane", f"a file of at most {MOST_POINTS} sightings")
        views = found.setdefault(_plane(row), {}).setdefault(row.text("point"), {})
        camera = _camera(row, names)
        if camera in views:
            raise row.mistake("camera", "each camera once per point")
        views[camera] = row.numbers("u", "v")
    if not found:
        raise InputError.of(f"{path} has no points", f"needs lines {','.join(COLUMNS)}")
    return {plane: sightings(cameras, list(points.values())) for plane, points in found.items()}


def sightings(cameras: Sequence[Camera], points: Sequence[Mapping[int, Sequence[float]]]) -> Sightings:
    """Points, each given as number of a camera -> its place in the picture, px."""
    pixel = np.full((len(points), len(cameras), 2), np.nan)
    for number, views in enumerate(points):
        for camera, place in views.items():
            pixel[number, camera] = place
    names, sizes = tuple(c.name for c in cameras), np.array([c.size for c in cameras])
    return Sightings(names, sizes, np.arange(len(points)), np.zeros(len(points), "i8"), pixel)


def _plane(row: Row) -> str:
    name = row.text("plane")
    if not is_name(name):
        raise row.mistake("plane", "a name of letters, digits, _ and -")
    return name


def _camera(row: Row, names: Mapping[str, int]) -> int:
    name = row.text("camera")
    if name not in names:
        raise row.mistake("camera", f"a camera of the room or its number: {', '.join(names)}")
    return names[name]
