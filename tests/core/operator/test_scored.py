"""What is scored follows from the graph: the tables of sinks, whatever their files are called."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.library.execute import scored_file
from followspot.people import Poses
from followspot.tracking import Tracks

GRAPHS = Path(__file__).parents[3] / "graphs"
GLOWBALLS = GRAPHS / "glowballs.yaml"


def test_a_run_is_scored_whatever_its_file_is_called(tmp_path: Path) -> None:
    with fs.run(GLOWBALLS, set={"save.path": "balls/here.csv"}, frames=10, out=tmp_path) as run:
        report = run.wait()
    assert (tmp_path / "balls/here.csv").exists()
    assert len(report.accuracy) == 3


def test_a_file_of_the_right_name_with_other_messages_is_not_scored(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    graph = tmp_path / "graph.yaml"
    stages = {
        "save": None,
        "blobs": {"uses": "sinks.csv", "in": {"messages": "fuse"}, "with": {"path": "tracks.csv"}},
    }
    interface = {"params": {"tracks_file": "blobs.path"}}
    graph.write_text(json.dumps({"extends": str(GLOWBALLS), "stages": stages, **interface}))
    assert main(["run", str(graph), "--frames", "5", "--quiet", "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/tracks.csv").exists()
    assert "accuracy" not in capsys.readouterr().out


def test_of_several_sinks_the_one_farthest_downstream_is_scored() -> None:
    plan = compile_graph(GRAPHS / "building.yaml")
    assert scored_file(plan, Tracks) == Path("tracks.csv")
    assert len([s for s in plan.stages if s.uses == "sinks.csv"]) > 1


def test_poses_are_told_from_tracks_by_their_type() -> None:
    plan = compile_graph(GRAPHS / "person_room.yaml", overrides=["save.path=persons.csv"])
    assert scored_file(plan, Poses) == Path("persons.csv")
    assert scored_file(plan, Tracks) is None


def test_the_report_names_the_scored_file_if_there_are_several(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = {"early": {"uses": "sinks.csv", "in": {"tracks": "track"}, "with": {"path": "early.csv"}}}
    graph = tmp_path / "graph.yaml"
    graph.write_text(json.dumps({"extends": str(GLOWBALLS), "stages": more}))
    for command in (["run", str(GLOWBALLS)], ["run", str(graph)]):
        assert main([*command, "--frames", "5", "--quiet", "--out", str(tmp_path / "out")]) == 0
    one, _, several = capsys.readouterr().out.partition("outputs: ")
    assert "accuracy against ground truth" in one
    assert "accuracy of early.csv (not of tracks.csv) against ground truth" in several
    command = ["run", str(graph), "--frames", "5", "--quiet", "--out", str(tmp_path / "out"), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["scored"] == "early.csv"
