"""caliscope's camera_array.toml: a table [cameras.N] for camera number N with video cam_N."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from followspot.room import Camera
from followspot_room.checks import holds, unique
from followspot_room.format import Calibration, Format, Texts
from followspot_room.formats.camera_table import camera_of, is_camera, table_of, toml_tables, toml_text


def parse(files: Texts) -> Calibration | None:
    """TOML with tables [cameras.N]; cameras that it ignores or that have no matrix are left out."""
    listed = (toml_tables(files) or {}).get("cameras")
    if not listed or not all(isinstance(table, dict) for table in listed.values()):
        return None
    chosen = {number: table for number, table in listed.items() if is_camera(table) and not _ignored(table)}
    notes = [
        f"camera cam_{number} is {'ignored' if _ignored(table) else 'not calibrated'} there and left out"
        for number, table in listed.items()
        if number not in chosen
    ]
    if not chosen:
        return None
    cameras = [camera_of(table, f"cam_{number}") for number, table in chosen.items()]
    return Calibration(unique(cameras), notes=tuple(notes))


def write(cameras: Sequence[Camera]) -> Texts:
    """camera_array.toml; a camera cam_N keeps its number, and the name stands beside it. Raises Unfit."""
    holds(cameras, ("pinhole", "fisheye"), "caliscope")
    numbers = [_number(camera.name) for camera in cameras]
    if None in numbers or len(set(numbers)) < len(numbers):
        numbers = list(range(len(cameras)))
    tables = {
        f"cameras.{number}": {"cam_id": number, "rotation_count": 0, **table_of(camera)}
        for number, camera in zip(numbers, cameras, strict=True)
    }
    return {"camera_array.toml": toml_text(tables)}


def _ignored(table: Mapping[str, Any]) -> bool:
    return table.get("ignore") is True


def _number(name: str) -> int | None:
    head, _, digits = name.rpartition("_")
    return int(digits) if head == "cam" and digits.isdecimal() and len(digits) < 10 else None


FORMAT = Format("caliscope", "caliscope's camera_array.toml: [cameras.0] with size, matrix", parse, write)
