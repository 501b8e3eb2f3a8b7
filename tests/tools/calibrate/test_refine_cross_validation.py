"""`calibrate refine` judges by places that took no part, and never writes a worse room in silence."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.tools.calibrate.carried_targets import FLOOR, RADIUS, TRUE, carried, off

from followspot import Camera, Room, Target
from followspot.cli.main import main
from followspot.messages import Array
from followspot.room_file import save
from followspot_calibrate.refine import command
from followspot_calibrate.refine.cross_validation import Comparison, cross_validate
from followspot_calibrate.refine.selection import select_sightings
from followspot_calibrate.target_sightings import TargetSightings

ROWS = 42


def clips(pixel: Array, shift: float = 0.0, rows: int = 30) -> TargetSightings:
    """Sightings of a target alone; camera 2 sees it `shift`, px, beside where it is."""
    seen = pixel[100 : 100 + rows].copy()
    seen[:, 2, 0] += shift
    return TargetSightings(seen, np.full(len(seen), 0.2))


def held(cameras: Sequence[Camera], shown: TargetSightings | None, rows: int = ROWS) -> Comparison | None:
    pixel = carried()[1][:rows]
    return cross_validate(
        cameras, select_sightings(cameras, pixel, np.full(rows, RADIUS), FLOOR), shown, FLOOR
    )


def test_refined_cameras_see_better_what_they_do_not_know() -> None:
    found = held(off(TRUE), None)
    assert found is not None
    assert found.clips is None
    assert not found.use_clips
    assert found.better
    assert found.best == found.alone < 0.6 * found.given


@pytest.mark.thorough
def test_clips_that_agree_are_used() -> None:
    found = held(off(TRUE), clips(carried()[1]))
    assert found is not None
    assert found.use_clips
    assert found.better
    assert found.best == found.clips < 0.6 * found.given


@pytest.mark.thorough
def test_clips_that_contradict_the_recording_are_not_used() -> None:
    found = held(off(TRUE), clips(carried()[1], 4.0, rows=60), rows=90)
    assert found is not None
    assert not found.use_clips
    assert found.best == found.alone < 0.7 * found.clips


def test_clips_may_be_a_little_worse_by_chance() -> None:
    assert Comparison(0.4, 0.100, 0.109).use_clips
    assert not Comparison(0.4, 0.100, 0.111).use_clips
    assert Comparison(0.4, 0.100, 0.111).best == 0.100
    assert not Comparison(0.1, 0.100, None).better


def test_too_few_places_are_not_compared() -> None:
    assert held(off(TRUE), None, rows=21) is None


def room(folder: Path, cameras: Sequence[Camera]) -> Path:
    path = folder / "room.yaml"
    target = Target("ball", RADIUS)
    save(Room("r", {one.name: one for one in cameras}, FLOOR, {"ball": target}), path)
    return path


@pytest.fixture
def recording(monkeypatch: pytest.MonkeyPatch) -> Array:
    """Sightings of a run that is never read, (N, C, 2) px."""
    pixel = carried()[1]
    seen = SimpleNamespace(pixel=pixel[:ROWS], target=np.zeros(ROWS, int))
    monkeypatch.setattr(command, "read_run", lambda *given: None)
    monkeypatch.setattr(command, "target_sightings", lambda *given: seen)
    return pixel


def refine(
    path: Path, capsys: pytest.CaptureFixture[str], *words: str | Path
) -> tuple[dict[str, object], str]:
    given = ["calibrate", "refine", "--room", path, "--run", path.parent, "--json", *words]
    assert main([str(word) for word in given]) == 0
    told = capsys.readouterr()
    return json.loads(told.out), told.err


def choose(monkeypatch: pytest.MonkeyPatch, given: float, alone: float, with_clips: float | None) -> None:
    """The comparison finds these errors, px."""
    monkeypatch.setattr(command, "cross_validate", lambda *_: Comparison(given, alone, with_clips))


def test_a_room_that_would_not_be_better_is_not_written(
    tmp_path: Path, recording: Array, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = room(tmp_path, off(TRUE))
    before = path.read_text()
    choose(monkeypatch, 0.12, 0.13, None)
    told, said = refine(path, capsys)
    assert path.read_text() == before
    assert told["written"] is False
    assert "the cameras stay as they are" in said
    choose(monkeypatch, 0.12, 0.11, None)
    told, said = refine(path, capsys)
    assert path.read_text() != before
    assert told["written"] is True
    assert said == ""


def test_clips_that_contradict_the_recording_are_left_out_and_named(
    tmp_path: Path, recording: Array, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command, "find_target_sightings", lambda *_: clips(recording))
    places = []
    for found in (0.25, 0.11):
        choose(monkeypatch, 0.4, 0.12, found)
        told, said = refine(room(tmp_path, off(TRUE)), capsys, "--clips", tmp_path, "--dry-run")
        assert ("the clips were left out" in said) is (found == 0.25)
        places.append(told["places"])
    assert places[1] == places[0] + 30
