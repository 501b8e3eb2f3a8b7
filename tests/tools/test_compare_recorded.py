"""Figures of `followspot compare` from the files of a run: recoveries, pairs, distances, fused positions."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from followspot.testing.tiny_room import tiny_room
from followspot_accuracy import TrackTable, TruthTable
from followspot_compare.recorded import detection_errors, pair_counts, read_fused
from followspot_compare.trial import recovery_of


def test_recoveries_are_right_within_15_cm_and_those_of_an_absent_target_never() -> None:
    time = np.arange(4) / 30
    xyz = np.zeros((4, 1, 3))
    seen = np.ones((4, 1), bool)
    truth = TruthTable(("red",), time, xyz, ~seen, seen, seen)
    place = np.array([[0.2, 0, 0], [0.1, 0, 0], [0, 0, 0]])
    tracks = TrackTable(("red", "blue"), time[[0, 2, 3]], np.array([0, 0, 1]), np.ones(3, "u1"), place)
    assert recovery_of(tracks, truth, "red") == (2, 2, 1)
    assert recovery_of(tracks, truth, "blue") == (4, 1, 1)


def test_pairs_of_a_target_are_counted_in_each_frame_that_has_its_track(tmp_path: Path) -> None:
    lines = [
        {"time": 1_000_000_000, "rows": [{"targets": "red blue"}, {"targets": "blue"}]},
        {"time": 1_033_333_333, "rows": [{"targets": "red"}]},
        {"time": 1_066_666_667, "rows": [{"targets": "red"}, {"targets": "red"}, {"targets": ""}]},
    ]
    (tmp_path / "pairs.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    time = np.array([1.0, 1.033333333, 1.0])
    tracks = TrackTable(("blue", "red"), time, np.array([0, 0, 1]), np.ones(3, "u1"), np.zeros((3, 3)))
    counts = pair_counts(tmp_path, tracks, ("red", "blue"))
    assert {name: count.tolist() for name, count in counts.items()} == {"blue": [2, 0], "red": [1]}
    assert pair_counts(tmp_path / "elsewhere", tracks, ("red", "blue")) == {}


def test_distance_from_detections_takes_the_nearest_blob_of_each_camera(tmp_path: Path) -> None:
    room = tiny_room()
    cameras = tuple(room.cameras.values())
    image = [((c.projection @ [0, 0, 0, 1])[:2] / (c.projection @ [0, 0, 0, 1])[2]).tolist() for c in cameras]
    near = [image[0][0] + 3, image[0][1] + 4]  # 5 px off
    far = [image[0][0] + 30, image[0][1]]
    rows = [
        {"targets": "red", "view_0": cameras[0].name, "view_1": cameras[1].name}
        | {"xy_0_0": xy[0], "xy_0_1": xy[1], "xy_1_0": image[1][0], "xy_1_1": image[1][1]}
        for xy in (near, far)
    ]
    line = {"time": 2_000_000_000, "rows": rows}
    (tmp_path / "candidates.jsonl").write_text(json.dumps(line) + "\n")
    tracks = TrackTable(("red",), np.array([2.0]), np.zeros(1, int), np.ones(1, "u1"), np.zeros((1, 3)))
    apart = detection_errors(tmp_path, tracks, ("red",), cameras)["red"]
    assert sorted(apart.tolist()) == pytest.approx([0.0, 5.0], abs=1e-9)
    without = TrackTable((), np.zeros(0), np.zeros(0, int), np.zeros(0, "u1"), np.zeros((0, 3)))
    assert detection_errors(tmp_path, without, ("red",), cameras) == {}


def test_fused_positions_count_only_where_the_target_is_tracked(tmp_path: Path) -> None:
    def row(name: str, xyz: tuple[float, ...], steps: int) -> dict[str, object]:
        return {"object": name, **dict(zip("xyz", xyz, strict=True)), "iterations": steps}

    lines = [
        {"time": 1_000_000_000, "rows": [row("red", (1, 0, 0), 3), row("blue", (2, 0, 0), 4)]},
        {"time": 1_033_333_333, "rows": [row("blue", (2, 1, 0), 5)]},
    ]
    (tmp_path / "positions.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    tracks = TrackTable(
        ("blue",), np.array([1.033333333]), np.zeros(1, int), np.ones(1, "u1"), np.zeros((1, 3))
    )
    fused = read_fused(tmp_path, tracks, ("red", "blue"))
    assert fused is not None
    assert fused.iterations.tolist() == [5]
    assert fused.tracks.xyz.tolist() == [[2.0, 1.0, 0.0]]
    assert read_fused(tmp_path / "elsewhere", tracks, ("red", "blue")) is None
