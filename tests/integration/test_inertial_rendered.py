"""`graphs/inertial.yaml` from pictures to tracks, with a ball that no camera sees for a second."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

import followspot as fs
from followspot import room_file
from followspot.context import Context
from followspot.plugins.registry import load_stage
from followspot_accuracy import read_tracks_csv, score, truth_of

ROOT = Path(__file__).parents[2]
STAGES = ROOT / "tests/stages/seeing.py"
ROOM = ROOT / "graphs/rooms/simulated_imu.yaml"
CAMERAS = ("cam0", "cam1", "cam2")
"""Two colour cameras and an infrared one."""
PERFORMANCE = {"frames": 156, "fps": 30, "projections": 0, "hide_balls": False}
CLOSED = 4.0
"""When a curtain is drawn before all cameras, for a second, s."""
GRAPH = f"""\
graph: curtain
extends: {ROOT}/graphs/inertial.yaml
room: room.yaml
stages:
  curtain:  {{uses: seeing.curtain, each: cameras, in: {{frame: camera}}, with: {{begin: {CLOSED}}}}}
  color:    {{in: {{frame: curtain}}}}
  infrared: {{in: {{frame: curtain}}}}
"""
PLACEMENT = """\
placement: wrist
workers:
  wrist: {sensors: [imu_red]}
"""


def made(folder: Path) -> Path:
    """The graph and its room: one ball, with a sensor."""
    room = yaml.safe_load(ROOM.read_text())
    room["cameras"] = {name: room["cameras"][name] for name in CAMERAS}
    red = room["targets"]["red"]
    for template in ("hue_histogram", "area", "gray"):
        red[template] = {name: red[template][name] for name in CAMERAS if name in red[template]}
    room["targets"] = {"red": red}
    room["sensors"] = {"imu_red": room["sensors"]["imu_red"]}
    for part in (*room["cameras"].values(), *room["sensors"].values(), {"source": room["truth"]}):
        part["source"]["with"] = part["source"]["with"] | PERFORMANCE
    (folder / "room.yaml").write_text(yaml.safe_dump(room, sort_keys=False))
    path = folder / "graph.yaml"
    path.write_text(GRAPH)
    return path


def run(graph: Path, out: Path, **options: Any) -> bytes:
    with fs.run(graph, out=out, plugin_files=[STAGES], **options) as handle:
        assert handle.wait().ok
    return (out / "tracks.csv").read_bytes()


def test_ball_that_no_camera_sees_for_a_second_is_covered_by_its_sensor(tmp_path: Path) -> None:
    run(made(tmp_path), tmp_path / "out")
    room = room_file.load(tmp_path / "room.yaml")
    assert room.truth is not None
    source = load_stage(room.truth.uses)(Context(room=room), **room.truth.params)
    source.setup()
    found = score(read_tracks_csv(tmp_path / "out/tracks.csv"), truth_of(source.process()))["red"]
    assert found.frames == PERFORMANCE["frames"]  # also behind the curtain
    assert found.coverage == 1.0
    assert found.bridged_frames >= PERFORMANCE["fps"]


@pytest.mark.thorough
def test_sensor_in_another_process_gives_the_same_tracks(tmp_path: Path) -> None:
    graph, placement = made(tmp_path), tmp_path / "placement.yaml"
    placement.write_text(PLACEMENT)
    assert run(graph, tmp_path / "two", placement=placement) == run(graph, tmp_path / "one")
