"""The situations that a benchmark tells apart, and the errors that it counts in them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.balls import situations
from followspot_accuracy import TrackTable, TruthTable

TIME = np.arange(10) / 10
ROOM = Path(__file__).parents[3] / "graphs/rooms/simulated.yaml"


def truth() -> TruthTable:
    """Red, hidden at first, moves at 3 m/s from 0.4 to 0.7 s; green comes near at 0.8 s."""
    red = np.interp(TIME, [0.4, 0.7], [0.0, 0.9])
    xyz = np.zeros((10, 2, 3))
    xyz[:, 0, 0], xyz[:, 1, 0], xyz[:, 1, 1] = red, red, np.where(TIME > 0.75, 0.24, 0.26)
    trackable, pair = np.ones((2, 10, 2), bool)
    trackable[0, 0] = False
    pair[7:, 0] = False
    return TruthTable(("red", "green"), TIME, xyz, np.zeros((10, 2), bool), trackable, pair)


def tracks(error: dict[int, float]) -> TrackTable:
    """Positions of red in these frames, so far above the truth, m."""
    frames = np.array(list(error))
    xyz = truth().xyz[frames, 0] + [[0.0, 0.0, one] for one in error.values()]
    return TrackTable(
        ("red",), TIME[frames], np.zeros(len(frames), int), np.zeros(len(frames), np.uint8), xyz
    )


def errors(error: dict[int, float]) -> dict[str, np.ndarray]:
    return {s: e for s, name, e in situations.errors_of(tracks(error), truth()) if name == "red"}


def test_frames_belong_to_the_situations_of_their_own_ball() -> None:
    red, green = (situations.situations(truth(), own) for own in (0, 1))
    for of in (red, green):
        assert of["all"].all()
        assert np.flatnonzero(of["beside"]).tolist() == [8, 9]
        assert np.flatnonzero(of["fast"]).tolist() == [5, 6], "the mean of both steps at 0.4 and 0.7 s is 1.5"
    assert np.flatnonzero(red["covered"]).tolist() == [7, 8, 9]
    assert not green["covered"].any()


def test_balls_change_hands_while_they_pass_each_other_near_by() -> None:
    """Green comes nearer between 0.7 and 0.8 s, by 2 cm, then by 6 cm in place of it."""
    assert not situations.situations(truth(), 0)["handover"].any(), "0.1 m/s is no hand-over"
    place = truth().xyz.copy()
    place[:, 1, 1] = np.where(TIME > 0.75, 0.2, 0.26)
    faster = replace(truth(), xyz=place)
    for own in (0, 1):
        of = situations.situations(faster, own)
        assert np.flatnonzero(of["handover"]).tolist() == [8]
        assert np.flatnonzero(of["beside"]).tolist() == [8, 9]


def test_errors_are_those_of_trackable_frames_in_each_situation() -> None:
    found = errors(dict.fromkeys(range(10), 0.002) | {5: 0.01, 9: 0.2})
    assert found["all"] == pytest.approx([0.002] * 4 + [0.01] + [0.002] * 3 + [0.2])
    assert found["fast"] == pytest.approx([0.01, 0.002])
    assert found["beside"] == pytest.approx([0.002, 0.2])
    assert found["covered"] == pytest.approx([0.002, 0.002, 0.2])


def test_a_frame_without_a_position_is_missed_and_has_no_error() -> None:
    beside = errors({8: 0.002})["beside"]
    assert beside == pytest.approx([0.002, np.nan], nan_ok=True)
    found = situations.figures([("red", beside)])
    assert (found.frames, found.missed) == (2, 1)
    assert found.rmse_mm == pytest.approx(2.0)


def test_the_worst_target_has_five_frames_and_outliers_are_missed_but_counted() -> None:
    few, many, best = np.full(4, 0.05), np.array([0.003, 0.004, 0.0, 0.16, 0.0]), np.full(6, 0.001)
    found = situations.figures([("few", few), ("many", many), ("best", best)])
    assert (found.frames, found.missed, found.worst) == (15, 1, "many")
    assert found.worst_mm == pytest.approx(1e3 * np.sqrt((9e-6 + 16e-6 + 0.16**2) / 5))
    nothing = situations.figures([])
    assert nothing == situations.Figures(0, 0, None, None, "-")


def test_a_fusion_is_measured_in_a_simulated_room() -> None:
    found = situations.measure([ROOM], situations.GRAPH, 12, {}, "balls.mean_shift")
    assert tuple(found) == situations.SITUATIONS
    assert 12 < found["all"].frames <= 36
    assert found["all"].missed == 0
    assert found["all"].rmse_mm is not None
    assert 0 < found["all"].rmse_mm < 10
    assert found["all"].worst.startswith("simulated ")
