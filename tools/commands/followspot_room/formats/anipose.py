"""TOML of aniposelib, which Pose2Sim and caliscope write as well: a table for each camera."""

from __future__ import annotations

from collections.abc import Sequence

from followspot.room import Camera
from followspot_room.checks import holds, unique
from followspot_room.format import Calibration, Format, Texts
from followspot_room.formats.camera_table import camera_of, is_camera, table_of, toml_tables, toml_text


def parse(files: Texts) -> Calibration | None:
    """TOML whose tables are cameras: [cam_0] or [any name] with size, matrix, distortions."""
    tables = toml_tables(files) or {}
    cameras = [camera_of(table, title) for title, table in tables.items() if is_camera(table)]
    return Calibration(unique(cameras)) if cameras else None


def write(cameras: Sequence[Camera]) -> Texts:
    """One TOML file. Raises Unfit."""
    holds(cameras, ("pinhole", "fisheye"), "aniposelib")
    tables = {f"cam_{number}": table_of(camera) for number, camera in enumerate(cameras)}
    return {"calibration.toml": toml_text({**tables, "metadata": {"adjusted": False, "error": 0.0}})}


FORMAT = Format("anipose", "TOML of aniposelib: [cam_0] with size, matrix, distortions", parse, write)
