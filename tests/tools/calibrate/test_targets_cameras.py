"""`calibrate targets` corrects cameras that contradict each other about the targets in their clips."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.tools.calibrate.ball_clips import POINTS, TRUE, write_clips

from followspot import Camera, Room
from followspot.cli.main import main
from followspot.geometry import project
from followspot.room_file import load, save
from followspot_calibrate.triangulation import triangulate

FLOOR = np.array([0.0, 0.0, 1.0, 0.0])


def off(pixels: float) -> list[Camera]:
    """Cameras whose principal points are off by so much, each in its own direction."""
    away = np.random.default_rng(2).normal(size=(len(TRUE), 2))
    away *= pixels / np.linalg.norm(away, axis=1, keepdims=True)
    moves = [np.array([[1, 0, x], [0, 1, y], [0, 0, 1]]) for x, y in away]
    return [replace(c, matrix=move @ c.matrix) for c, move in zip(TRUE, moves, strict=True)]


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_clips(tmp_path_factory.mktemp("clips"))


def room_of(cameras: Sequence[Camera], folder: Path) -> Path:
    save(Room("studio", {c.name: c for c in cameras}, {"floor": FLOOR}), folder / "room.yaml")
    return folder / "room.yaml"


def error_mm(cameras: Sequence[Camera]) -> float:
    """RMSE of the points' exact images, triangulated with other cameras, mm."""
    exact = np.stack([project(camera, POINTS) for camera in TRUE], axis=1)
    return float(1000 * np.sqrt(np.square(triangulate(cameras, exact).points - POINTS).sum(axis=1).mean()))


def without_targets(room: Path) -> str:
    return re.sub(r"(?ms)^targets:.*?(?=^\S|\Z)", "", room.read_text())


def test_cameras_that_are_slightly_off_are_corrected_once(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = room_of(off(0.7), tmp_path)
    given, command = load(path), ["calibrate", "targets", "--room", str(path), "--clips", str(clips)]
    assert main(command) == 0
    assert "the cameras contradicted each other" in capsys.readouterr().out
    assert "Cameras corrected" in path.with_suffix(".targets.html").read_text()
    found = load(path)
    assert error_mm(list(found.cameras.values())) < 0.6 * error_mm(list(given.cameras.values()))
    assert 0 < np.abs(found.planes["floor"] - FLOOR).max() < 0.02
    assert list(found.targets) == ["green"]
    text = path.read_text()
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["correction"] is None
    assert path.read_text() == text


LATE = [*off(0.7)[:4], replace(TRUE[4], clock_offset=0.01)]


@pytest.mark.parametrize(("cameras", "words"), [(TRUE, []), (off(0.7), ["--keep-cameras"]), (LATE, [])])
def test_cameras_that_agree_are_to_stay_or_are_not_synchronised_are_left_alone(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], cameras: list[Camera], words: list[str]
) -> None:
    path = room_of(cameras, tmp_path)
    given = without_targets(path)
    assert main(["calibrate", "targets", "--room", str(path), "--clips", str(clips), *words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["correction"] is None
    assert without_targets(path) == given


@pytest.mark.parametrize(
    "lamp", [(0.8, 0.0, 0.6), pytest.param((0.5, -0.7, 0.5), marks=pytest.mark.thorough)]
)
def test_the_light_on_a_ball_is_no_reason_to_correct_exact_cameras(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], lamp: tuple[float, float, float]
) -> None:
    clips = write_clips(tmp_path / "clips", light=np.array(lamp) / np.linalg.norm(lamp))
    path = room_of(TRUE, tmp_path)
    given = without_targets(path)
    assert main(["calibrate", "targets", "--room", str(path), "--clips", str(clips), "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["correction"] is None
    assert "contradict" not in said.err
    assert without_targets(path) == given


def test_clips_that_do_not_begin_together_and_cameras_that_have_moved_are_named(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Cameras stay: what is far off is not corrected by clips of a few seconds."""
    away = replace(TRUE[3], translation=TRUE[3].translation + np.array([0.3, 0.0, 0.0]))
    moved = [*TRUE[:3], away, *TRUE[4:]]
    late = write_clips(tmp_path / "late", late=5)
    for cameras, seen, name in ((TRUE, late, "cam1"), (moved, clips, "cam3")):
        path = room_of(cameras, tmp_path)
        given = without_targets(path)
        assert main(["calibrate", "targets", "--room", str(path), "--clips", str(seen)]) == 0
        assert f"warning: {name} and the other cameras see the targets" in capsys.readouterr().err
        assert without_targets(path) == given


def test_cameras_whose_clips_cannot_tell_them_right_stay_and_are_warned_about(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Fifteen moments are too few."""
    few = write_clips(tmp_path / "few")
    for picture in few.rglob("*.png"):
        if int(picture.stem) >= 15:
            picture.unlink()
    path = room_of(off(0.7), tmp_path)
    given = without_targets(path)
    assert main(["calibrate", "targets", "--room", str(path), "--clips", str(few)]) == 0
    said = capsys.readouterr().err
    assert "cameras contradict each other about the targets by" in said
    assert "15 sightings of targets that fit the other cameras, 20 needed" in said
    assert without_targets(path) == given


def test_a_clip_that_cannot_be_read_is_named_and_cameras_stay(
    clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = Path(shutil.copytree(clips, tmp_path / "clips"))
    shutil.rmtree(broken / "green/cam2")
    (broken / "green/cam2.mkv").write_text("no video")
    path = room_of(off(0.7), tmp_path)
    given = without_targets(path)
    assert main(["calibrate", "targets", "--room", str(path), "--clips", str(broken)]) == 0
    said = capsys.readouterr().err
    assert re.search(r"cameras were not held against each other: .*cam2\.mkv cannot be read", said)
    assert without_targets(path) == given
