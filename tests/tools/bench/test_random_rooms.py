"""Random rooms: equal for equal seeds, seen by their cameras, and judged by what users would call weak."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.balls.random_rooms import BY_CHANCE, PERFORMED, Case, table, weaknesses
from benching.random_rooms import random_room
from followspot.geometry import project
from followspot.room_document.data import to_data
from followspot.room_file import load

ROOMS = Path(__file__).parents[3] / "graphs" / "rooms"

GOOD = {
    "coverage": 1.0,
    "rmse_mm": 3.0,
    "p95_mm": 8.0,
    "identity_switches": 0,
    "false_positions": 0,
    "hidden_frames": 100,
    "target": "red",
    "room": "7",
    "fusion": "balls.bundle",
}


def test_a_seed_is_a_room() -> None:
    assert to_data(random_room(5, 60)) == to_data(random_room(5, 60))
    assert to_data(random_room(5, 60)) != to_data(random_room(6, 60))


@pytest.mark.parametrize("seed", range(40))
def test_every_camera_sees_the_middle_of_the_room_upright(seed: int) -> None:
    room = random_room(seed, 60)
    kinds = [camera.kind for camera in room.cameras.values()]
    assert len(kinds) in range(4, 9)
    assert abs(kinds.count("color") - kinds.count("infrared")) <= 1
    assert len(room.targets) in {3, 4, 5, 6}
    middle = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 1.5]])
    for camera in room.cameras.values():
        low, high = project(camera, middle)
        assert np.clip(low, 0, [319, 239]).tolist() == low.tolist()
        assert high[1] < low[1]
        assert np.linalg.det(camera.rotation) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"coverage": 0.96}, "coverage"),
        ({"rmse_mm": 10.1}, "RMSE"),
        ({"identity_switches": 1}, "identity"),
        ({"false_positions": 1}, "false"),
    ],
)
def test_a_target_is_weak_for_each_reason(change: dict[str, float], reason: str) -> None:
    assert weaknesses(GOOD, BY_CHANCE) == []
    assert weaknesses({**GOOD, **change}, BY_CHANCE) == [reason]


@pytest.mark.parametrize(
    ("change", "reasons"),
    [
        ({"coverage": 0.995, "rmse_mm": 7.0, "false_positions": 0}, []),
        ({"coverage": 0.994}, ["coverage"]),
        ({"rmse_mm": 7.1}, ["RMSE"]),
        ({"rmse_mm": 12.0, "fusion": "balls.mean_shift"}, []),
        ({"rmse_mm": 12.1, "fusion": "balls.mean_shift"}, ["RMSE"]),
        ({"false_positions": 1, "hidden_frames": 200}, []),
        ({"false_positions": 1, "hidden_frames": 199}, ["false"]),
    ],
)
def test_performances_keep_the_bars_of_the_room_that_they_are_of(
    change: dict[str, float], reasons: list[str]
) -> None:
    assert weaknesses({**GOOD, **change}, PERFORMED) == reasons


def test_a_performance_of_a_room_differs_in_its_seed_and_length_alone(tmp_path: Path) -> None:
    room = ROOMS / "simulated6.yaml"
    made, own = (to_data(load(path)) for path in (Case(107, room).made(90, tmp_path), room))
    assert Case(107, room).name == "simulated6 107"
    uses = [made["truth"], *(camera["source"] for camera in made["cameras"].values())]
    assert all(use["with"].items() >= {"seed": 107, "frames": 90}.items() for use in uses)
    before = [own["truth"], *(camera["source"] for camera in own["cameras"].values())]
    for use, old in zip(uses, before, strict=True):
        assert use["folder"] != old["folder"], "the new file stands elsewhere"
        use["with"] |= {key: old["with"][key] for key in ("seed", "frames")}
        use["folder"] = old["folder"]
    assert made == own


def test_a_target_that_was_never_trackable_is_not_weak() -> None:
    assert weaknesses({**GOOD, "coverage": None, "rmse_mm": None}, BY_CHANCE) == []


def test_the_table_counts_weak_targets_of_each_fusion() -> None:
    text = table([GOOD, {**GOOD, "coverage": 0.5}, {**GOOD, "fusion": "balls.mean_shift"}], BY_CHANCE)
    assert "balls.bundle: 1 of 2 targets are weak" in text
    assert "balls.mean_shift: 0 of 1 targets are weak" in text
    assert "| 7 | balls.bundle | red | coverage | 0.5 | 3 | 8 |" in text
