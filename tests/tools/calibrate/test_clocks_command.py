"""Cameras that are not synchronised, from pictures to millimetres, in a room whose clocks are known."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from followspot import Room, room_file
from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.messages import Array
from followspot.operator.launch import run_plan
from followspot.operator.reporting.truth import run_scores
from followspot.room import StageUse
from followspot.worker.wiring import RunOptions
from followspot_calibrate.clocks.command import with_offsets
from followspot_calibrate.tracked import detectors
from followspot_sim.recording import clock_offset_of, parameters_of, record

GRAPHS = Path(__file__).parents[3] / "graphs"
GRAPH = str(GRAPHS / "glowballs.yaml")
UNSYNCHRONISED = room_file.load(GRAPHS / "rooms/simulated_unsynchronised.yaml")
TRUE = np.array([clock_offset_of(camera) for camera in UNSYNCHRONISED.cameras.values()])


def recorded(room: Room, folder: Path) -> Path:
    """Two seconds at 30 frames per second as videos, and a room file that plays them."""
    params = parameters_of(room, frames=60, seed=2).model_copy(update={"fps": 30.0})
    record(room, params, folder)
    cameras = {
        name: replace(camera, source=StageUse("cameras.video", {"path": f"{name}.mkv"}))
        for name, camera in room.cameras.items()
    }
    truth = StageUse("cameras.truth_csv", {"path": "truth.csv"})
    room_file.save(replace(room, cameras=cameras, truth=truth), folder / "room.yaml")
    return folder / "room.yaml"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(UNSYNCHRONISED, tmp_path_factory.mktemp("unsynchronised"))


def errors(room: Path, offset: Array | None, out: Path) -> Array:
    """RMSE of each target, mm, with the clock offsets given or those of the room file."""
    plan = compile_graph(GRAPH, room=room, overrides=["fuse.uses=balls.bundle"])
    if offset is not None:
        plan = replace(plan, room=with_offsets(plan.room, offset))
    report = run_plan(plan, RunOptions(out, frames=30))
    scores = run_scores(plan, out, report.frames)["targets"].to_data()
    return np.array([one["rmse_mm"] for one in scores.values()])


@pytest.mark.thorough
def test_offsets_are_found_and_track_as_well_as_if_they_were_known(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = errors(recording, np.zeros(6), tmp_path)
    room = tmp_path / "room.yaml"
    room.write_text(recording.read_text().replace("path: ", f"path: {recording.parent}/"))
    arguments = ["calibrate", "clocks", "--room", str(room), "--graph", GRAPH, "--rounds", "2", "--json"]
    assert main(arguments) == 0
    told = json.loads(capsys.readouterr().out)["cameras"]
    written = np.array([c.clock_offset for c in room_file.load(room).cameras.values()])
    assert written == pytest.approx([told[name]["clock_offset"] for name in told])
    assert written == pytest.approx(TRUE, abs=1e-3)
    page = room.with_suffix(".clocks.html").read_text()
    assert all(f"{1e3 * offset:+.2f} ms" in page for offset in written)
    after = errors(room, None, tmp_path)
    known = errors(recording, TRUE, tmp_path)
    assert (after < 0.6 * before).all()
    assert after.mean() < 1.05 * known.mean()


def test_a_dry_run_writes_nothing_and_too_little_motion_is_refused(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = recording.read_text()
    arguments = ["calibrate", "clocks", "--room", str(recording), "--graph", GRAPH, "--dry-run"]
    assert main([*arguments, "--frames", "5"]) == 1
    assert "30 needed" in capsys.readouterr().err
    assert main([*arguments, "--rounds", "1", "--reference", "cam2", "--frames", "45"]) == 0
    assert re.search(r"cam2 +\+0\.00 +0\.00 ", capsys.readouterr().out)
    assert recording.read_text() == text


def test_what_cannot_be_calibrated_is_said(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    base = ["calibrate", "clocks", "--room", str(recording)]
    assert main([*base, "--graph", GRAPH, "--reference", "cam9"]) == 2
    assert 'no camera "cam9"' in capsys.readouterr().err
    assert main([*base, "--graph", str(GRAPHS / "single_camera.yaml")]) == 2
    assert "joins the blobs of several cameras" in capsys.readouterr().err
    assert main([*base, "--graph", "nowhere.yaml"]) == 2
    assert "nowhere.yaml" in capsys.readouterr().err
    for limit in ("0", "-1", "nan", "inf"):
        assert main([*base, "--graph", GRAPH, "--limit", limit]) == 2
        assert f"--limit {limit} is not positive" in capsys.readouterr().err


def test_the_blobs_that_are_paired_are_those_behind_a_search_gate() -> None:
    assert detectors(compile_graph(GRAPH)) == ("color", "infrared")
    gated = compile_graph(GRAPHS / "experiments/search_gate.yaml")
    assert detectors(gated) == ("near_color", "near_infrared")
