"""The benchmark of hard situations runs, and its rooms differ as they say."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

import bench_strangers
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable


def test_each_situation_is_scored_for_each_seed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "--kinds near --seeds 3 --frames 4 --json"
    monkeypatch.setattr(sys, "argv", ["bench_strangers.py", *words.split()])
    bench_strangers.main()
    told = json.loads(capsys.readouterr().out)
    assert list(told) == ["near"]
    assert [list(figures) for figures in told["near"]] == [list(bench_strangers.COLUMNS)]


@pytest.mark.parametrize("kind", bench_strangers.KINDS)
def test_cameras_and_truth_of_a_situation_have_the_same_people(kind: str) -> None:
    room = bench_strangers.room_of(kind, 7, 9)
    (camera,) = room.cameras.values()
    assert camera.source is not None
    assert room.truth is not None
    assert camera.source.params == room.truth.params
    assert camera.source.params["seed"] == 7
    assert camera.source.params["frames"] == 9


@pytest.mark.parametrize(("false", "longest"), [((), 0.0), ((2,), 0.5), ((1, 2, 3, 6), 1.5), ((6, 7), 1.0)])
def test_the_longest_false_person_is_told(false: tuple[int, ...], longest: float) -> None:
    time = np.arange(8) * 0.5
    there = np.zeros((8, 6))
    truth = PoseTruthTable((1,), time, there[:, None], np.ones((8, 1)), np.zeros(2))
    pose = there.copy()
    pose[list(false), 0] = 0.7
    found = PoseTable(time, np.ones(8, int), pose)
    assert bench_strangers.longest_false(found, truth) == pytest.approx(longest)


def test_a_false_person_that_was_away_meanwhile_is_two_short_ones() -> None:
    time = np.arange(8) * 0.5
    there = np.zeros((8, 6))
    truth = PoseTruthTable((1,), time, there[:, None], np.ones((8, 1)), np.zeros(2))
    seen = np.array([1, 2, 6])
    pose = there[seen] + [0.7, 0, 0, 0, 0, 0]
    assert bench_strangers.longest_false(PoseTable(time[seen], np.ones(3, int), pose), truth) == 1.0
