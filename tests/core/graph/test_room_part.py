"""`--cameras` runs a part of a room, whatever the room says of its other cameras."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.graph.compile import compile_graph

GRAPHS = Path(__file__).parents[3] / "graphs"
DEMO = GRAPHS / "glowballs.yaml"


def test_the_plan_is_that_of_a_room_without_the_other_cameras(tmp_path: Path) -> None:
    room = tmp_path / "room.yaml"
    own = "color/cam0.minimum_brightness: 60, color/cam2.minimum_brightness: 70"
    tunes = f"tune: {{{own}, balls.color_blobs.similarity: 0.8}}"
    room.write_text((GRAPHS / "rooms" / "simulated.yaml").read_text() + tunes + "\n")
    plan = compile_graph(DEMO, room=room, cameras=["cam3", "cam0"])
    assert list(plan.room.cameras) == ["cam0", "cam3"], "in the order of the room"
    assert {name for name in (stage.name for stage in plan.stages) if "/" in name} == {
        "camera/cam0",
        "camera/cam3",
        "color/cam0",
        "infrared/cam3",
    }
    for target in plan.room.targets.values():
        assert set(target.hue_histogram) == {"cam0"}
        assert set(target.area) <= {"cam0", "cam3"}
    assert set(plan.room.tune) == {"color/cam0.minimum_brightness", "balls.color_blobs.similarity"}
    assert not [note for note in plan.notes if "cam2" in note]


def test_a_camera_that_the_room_does_not_have_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(DEMO), "--cameras", "cam0,kam3"]) == 2
    said = capsys.readouterr().err
    assert '--cameras:1:1: the room has no camera "kam3"' in said
    assert 'did you mean "cam3"?' in said
    assert main(["check", str(DEMO), "--cameras", "kam3"]) == 2
    assert capsys.readouterr().err.endswith("\n1 mistake, nothing was started\n"), "no others follow from it"
    with pytest.raises(SystemExit):
        main(["check", str(DEMO), "--cameras", ","])
    assert "name at least one camera" in capsys.readouterr().err


def test_a_zone_without_cameras_is_a_mistake_of_the_graph_that_needs_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["check", str(GRAPHS / "building.yaml"), "--cameras", "hall0,hall1"]) == 2
    assert 'sub-graph "stage" serves cameras[zone=stage]' in capsys.readouterr().err


def test_a_part_of_a_room_tracks_from_the_command_line_and_in_a_script(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--cameras", "cam0,cam1,cam3", "--frames", "12", "--quiet", "--json"]
    assert main(["run", str(DEMO), *options, "--out", str(tmp_path / "a")]) == 0
    edges = json.loads(capsys.readouterr().out)["edges"]
    assert {edge["from"] for edge in edges if edge["from"].startswith("camera/")} == {
        "camera/cam0.out",
        "camera/cam1.out",
        "camera/cam3.out",
    }
    cameras = ["cam0", "cam1", "cam3"]
    with fs.run(DEMO, cameras=cameras, frames=12, out=tmp_path / "b") as run:
        run.wait()
    assert fs.check(DEMO, cameras=cameras) == []
    found = (tmp_path / "a" / "tracks.csv").read_bytes()
    assert found.count(b"\n") > 3
    assert (tmp_path / "b" / "tracks.csv").read_bytes() == found
