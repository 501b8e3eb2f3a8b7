"""Rooms that are well formed, with lengths that no room has in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.core.graph.files import TOY, write

import followspot as fs

SIMULATED = Path(__file__).parents[3] / "graphs/rooms/simulated.yaml"
GRAPH = "graph: g\nroom: room.yaml\nstages:\n  camera: {uses: toy.camera, each: cameras, with: {frames: 2}}\n"


def told(
    folder: Path, scale: float = 1.0, radius: float = 0.0762, floor: float = 0.0
) -> list[tuple[str, str]]:
    """Each warning with its line in the room file. scale: factor of the distances between cameras."""
    data = yaml.safe_load(SIMULATED.read_text())
    for camera in data["cameras"].values():
        del camera["source"]
        camera["translation"] = (scale * np.array(camera["translation"])).tolist()
    data = {
        "cameras": data["cameras"],
        "planes": {"floor": [0.0, 0.0, 1.0, floor]},
        "targets": {"ball": {"radius": radius}},
    }
    room = yaml.safe_dump(data, sort_keys=False, default_flow_style=None)
    lines = room.splitlines()
    found = fs.check(write(folder, graph=GRAPH, room=room), plugin_files=[TOY])
    placed = [(m.text, m.place) for m in found if m.place is not None and "room.yaml" in m.place.file]
    assert all(m.warning and m.remedy for m in found)
    return [(text, lines[place.line - 1]) for text, place in placed]


@pytest.mark.parametrize(("scale", "radius"), [(1.0, 0.0762), (0.1, 0.02), (20.0, 0.11), (1.0, 0.002)])
def test_rooms_from_a_table_to_a_stadium_are_fine(tmp_path: Path, scale: float, radius: float) -> None:
    assert told(tmp_path, scale, radius) == []


@pytest.mark.parametrize("radius", [76.2, 7.62, 1e-5])
def test_a_radius_that_no_target_has_is_told_at_its_line(tmp_path: Path, radius: float) -> None:
    ((text, line),) = told(tmp_path, radius=radius)
    assert text == f"target ball has a radius of {radius:g} m"
    assert "radius" in line


def test_a_target_that_reaches_from_camera_to_camera_is_told(tmp_path: Path) -> None:
    ((text, _),) = told(tmp_path, scale=0.3, radius=2.9)
    assert text.startswith("target ball has a radius of 2.9 m, but no cameras are more than")


@pytest.mark.parametrize("scale", [1000.0, 1e-5])
def test_cameras_that_are_too_far_apart_or_at_one_place_are_told(tmp_path: Path, scale: float) -> None:
    (text, line), *planes = told(tmp_path, scale)
    assert text.startswith("cameras cam")
    assert "translation" in line
    assert [found.partition(" is ")[0] for found, _ in planes] == (["plane floor"] if scale > 1 else [])


def test_a_plane_in_other_units_than_the_cameras_is_told(tmp_path: Path) -> None:
    ((text, line),) = told(tmp_path, floor=3000.0)
    assert text.startswith("plane floor is 3")
    assert "floor" in line
