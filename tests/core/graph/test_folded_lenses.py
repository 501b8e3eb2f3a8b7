"""Rooms whose lens models are not one to one within the picture."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from tests.core.graph.files import TOY, write

import followspot as fs

SIMULATED = Path(__file__).parents[3] / "graphs/rooms/simulated.yaml"
GRAPH = "graph: g\nroom: room.yaml\nstages:\n  camera: {uses: toy.camera, each: cameras, with: {frames: 2}}\n"


def told(folder: Path, model: str, distortion: list[float]) -> list[tuple[str, str]]:
    """Each warning about a room with one such lens, with its line in the room file."""
    cameras = yaml.safe_load(SIMULATED.read_text())["cameras"]
    for camera in cameras.values():
        del camera["source"]
    cameras["cam2"] |= {"model": model, "distortion": distortion}
    room = yaml.safe_dump({"cameras": cameras}, sort_keys=False, default_flow_style=None)
    found = fs.check(write(folder, graph=GRAPH, room=room), plugin_files=[TOY])
    assert all(m.warning and m.remedy for m in found)
    placed = [(m.text, m.place) for m in found if m.place is not None and "room.yaml" in m.place.file]
    return [(text, room.splitlines()[place.line - 1]) for text, place in placed]


@pytest.mark.parametrize(
    ("model", "distortion"),
    [
        ("pinhole", [9, 9, 9, 9, 9]),
        ("pinhole", [-2, 0, 0, 0, 0]),
        ("pinhole", [-0.3, 0.1, -0.9, 0.001, 0.0]),  # k1, k2, k3, p1, p2
        ("rational", [9] * 8),
        ("fisheye", [-2, 0, 0, 0]),
    ],
)
def test_a_lens_that_folds_within_its_picture_is_told_at_its_line(
    tmp_path: Path, model: str, distortion: list[float]
) -> None:
    ((text, line),) = told(tmp_path, model, distortion)
    assert text.startswith("the distortion of camera cam2 is not one to one in ")
    assert "distortion" in line


@pytest.mark.parametrize(
    ("model", "distortion"),
    [
        ("pinhole", [-0.3, 0.1, 0.001, -0.001, 0.0]),
        ("pinhole", [0.1, 0.1, 0.01, 0.01, 0.01]),
        ("fisheye", [-0.05, 0.01, 0, 0]),
        ("rational", [0.3, 0.1, 0.001, -0.001, 0.0, 0.6, 0.2, 0.01]),
        ("cylinder", []),
        ("pinhole", [0.0, 0.0, 0.0, 0.0, 5e-324]),  # the smallest number, by which nothing can be divided
        ("rational", [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5e-324]),
    ],
)
def test_lenses_of_real_cameras_are_fine(tmp_path: Path, model: str, distortion: list[float]) -> None:
    assert told(tmp_path, model, distortion) == []
