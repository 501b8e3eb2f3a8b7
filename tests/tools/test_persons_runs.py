"""Graphs of poses run in a room with truth: figures at the end of a run, and variants compared."""

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot.cli.main import main
from followspot_accuracy import PersonsScore, PoseTable, PoseTruthTable, score_persons
from followspot_compare.persons import PERSON_COLUMNS, persons_means, persons_text
from followspot_compare.report import Comparison, data, text
from followspot_compare.trial import Trial

ROOM = """
room: corner
cameras:
  left:
    kind: color
    size: [64, 48]
    matrix: [[50, 0, 31.5], [0, 50, 23.5], [0, 0, 1]]
    rotation: [[0, -1, 0], [0, 0, -1], [1, 0, 0]]
    translation: [0, 1.2, 0]
    source: {uses: cameras.images, with: {path: left, fps: 10}}
truth: {uses: cameras.pose_truth_csv, with: {path: left_gt.csv}}
"""
GRAPH = """
graph: standing
stages:
  camera: {uses: room.source, each: cameras}
  pose: {uses: standing.standing, each: cameras, in: {frame: camera}}
  save: {uses: sinks.csv, in: {poses: pose}, with: {path: poses.csv}}
"""
PLUGIN = '''
import numpy as np
from followspot import Field, Stage, StageParams
from followspot.people import Poses
from followspot.tracking import Frame


class Standing(Stage):
    """A tracker that sees a person stand at (2, 0), facing the camera."""

    per_camera = True

    class Params(StageParams):
        height: float = Field(1.7, description="of the person", unit="m")

    def process(self, frame: Frame) -> Poses:
        one = np.ones(1)
        return Poses(
            camera=frame.camera, person=np.array([4], "i4"), state=np.ones(1, "u1"),
            xy=np.array([[2.0, 0.0]]), height=self.params.height * one, heading=np.pi * one,
            pan=0 * one, tilt=0 * one, sigma=np.zeros((1, 6)), confidence=one,
        )
'''
TRUE_HEAD = "time,person,x,y,z_head_top,r,torso_heading_room,torso_heading,head_pan,head_tilt,visible_upper\n"


@pytest.fixture(scope="module")
def corner(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A room with a person who stands still, and a graph whose tracker knows that."""
    tmp_path = tmp_path_factory.mktemp("corner")
    (tmp_path / "left").mkdir()
    rows = []
    for number in range(5):
        cv2.imwrite(str(tmp_path / f"left/{number}.png"), np.zeros((48, 64, 3), "u1"))
        rows.append(f"{number / 10},1,2,0,1.7,2,3.14159265,0,0,0,1\n")
    (tmp_path / "left_gt.csv").write_text(TRUE_HEAD + "".join(rows))
    (tmp_path / "room.yaml").write_text(ROOM)
    (tmp_path / "graph.yaml").write_text(GRAPH)
    (tmp_path / "standing.py").write_text(PLUGIN)
    return tmp_path


def arguments(corner: Path, graph: str = "graph.yaml") -> list[str]:
    files = [str(corner / graph), "--room", str(corner / "room.yaml")]
    return [*files, "--plugin", str(corner / "standing.py"), "--out", str(corner / "out"), "--quiet"]


def score(height_error: float, *, switched: bool = False) -> PersonsScore:
    pose = np.tile([2.0, 0, 1.7, 0, 0, 0], (10, 1, 1))
    truth = PoseTruthTable((1,), np.arange(10) / 10, pose, np.ones((10, 1)), np.zeros(2))
    reported = pose[:, 0] + [0, 0, height_error, 0, 0, 0]
    numbers = np.where(switched & (np.arange(10) > 4), 2, 1)
    return score_persons(PoseTable(truth.time, numbers, reported), truth)


def trial(variant: str, room: str, persons: PersonsScore) -> Trial:
    return Trial(variant, room, 10, 2.0, 1.5, {}, (), persons)


def column(key: str, *scores: PersonsScore) -> float:
    return next(c for c in PERSON_COLUMNS if c.key == key).of(scores)


def test_figures_of_persons_stand_at_the_end_of_a_run(
    corner: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", *arguments(corner), "--set", "pose.height=1.8", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["targets"] == {}
    assert result["persons"]["1"]["height_cm"]["mean"] == pytest.approx(10)
    assert result["persons"]["1"]["torso"]["median_deg"] < 0.01
    assert result["persons"]["all"]["false_rows"] == 0
    assert result["persons"]["all"]["frames_in_all"] == 5
    assert main(["run", *arguments(corner)]) == 0
    assert "height: mean ± sigma" in capsys.readouterr().out


def test_run_that_is_stopped_early_is_measured_over_its_own_frames(
    corner: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", *arguments(corner), "--frames", "2", "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)["persons"]["all"]
    assert (whole["frames"], whole["coverage"]) == (2, 1.0)


def test_variants_of_a_pose_graph_are_compared(corner: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", *arguments(corner), "--variant", "tall:pose.height=1.75", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["persons"]["graph"]["height_sigma_cm"] == pytest.approx(0, abs=1e-9)
    first, tall = result["trials"]
    assert tall["persons"]["all"]["height_cm"]["mean"] == pytest.approx(5)
    assert (first["targets"], first["frames"]) == ({}, 5)
    assert not list((corner / "out").glob("*.svg"))


def test_graph_that_writes_no_poses_says_what_it_needs(
    corner: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    elsewhere = GRAPH.replace("uses: sinks.csv", "uses: sinks.jsonl")
    (corner / "elsewhere.yaml").write_text(elsewhere)
    assert main(["compare", *arguments(corner, "elsewhere.yaml")]) == 1
    assert "writes no Poses; it needs a stage sinks.csv" in capsys.readouterr().err


def test_several_rooms_share_a_mean_a_sum_or_the_slowest() -> None:
    good, bad = score(0.0), score(0.1, switched=True)
    assert column("switches", good, bad) == 1
    assert column("acquire_s", good, bad) == 0
    assert math.isnan(column("vanish_s", good, bad))
    assert column("coverage_percent", good, bad) == 100


def test_table_has_a_group_per_room_and_one_for_all_rooms() -> None:
    trials = [trial(v, room, score(0.0)) for v in ("plain", "other") for room in ("hall", "attic")]
    comparison = Comparison(tuple(trials))
    shown = text(comparison)
    assert "poses against ground truth" in shown
    assert "accuracy against ground truth" not in shown
    lines = [line.split()[0] for line in persons_text(comparison.persons()).splitlines()[2:]]
    assert lines == ["hall", "plain", "other", "attic", "plain", "other", "all", "plain", "other"]
    assert data(comparison)["persons"] == persons_means(comparison.persons())
    assert data(comparison)["persons"]["plain"]["vanish_s"] is None
