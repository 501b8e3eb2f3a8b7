"""The tables of a paper's page are those of a comparison."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import paper_tables


def target(**other: Any) -> dict[str, Any]:
    return {
        "frames": 100,
        "coverage": 0.9,
        "rmse_mm": 10.0,
        "median_mm": 5.0,
        "identity_switches": 1,
        "hidden_frames": 20,
        "false_positions": 2,
        "recoveries_found": 4,
        "recoveries_sought": 50,
        "recoveries_false": 1,
        "detection_px": 0.5,
        "detection_std_px": 0.4,
        "reprojection_px": 0.3,
        "jerk_cost": 0.001,
        "true_jerk_cost": 0.0001,
        "pairs": [12.0, 6.0, 15.0],
    } | other


def test_means_are_over_targets_that_were_there_and_sums_over_all() -> None:
    ghost = target(frames=0, coverage=None, rmse_mm=None, pairs=[None] * 3, recoveries_found=0)
    cells = paper_tables.figures([target(), target(coverage=0.7, pairs=[None] * 3), ghost])
    assert cells[:3] == ("80.0 %", "10.0 mm", "5.0 mm")
    assert cells[3:6] == ("3", "6 of 60", "3 of 8")
    assert cells[6:] == ("2.00 %", "0.50 px", "12.0")


def test_the_tables_have_a_row_for_each_variant_and_for_each_room(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trials = [
        {"variant": variant, "room": room, "targets": {"red": target()}}
        for variant in ("published", "recorded", "other")
        for room in ("dev1", "dev2")
    ]
    path = tmp_path / "compare.json"
    variants = ["published", "recorded", "other"]
    path.write_text(json.dumps({"variants": variants, "rooms": ["dev1", "dev2"], "trials": trials}))
    paper_tables.main(str(path))
    first, second, third = capsys.readouterr().out.strip().split("\n\n")
    assert [line.split(" | ")[0] for line in first.splitlines()[2:]] == [f"| {v}" for v in variants]
    assert len(second.splitlines()) == 2 + 4
    assert second.splitlines()[2].startswith("| dev1 | published | 90.0 % |")
    assert [line.split(" | ")[0] for line in third.splitlines()[2:]] == ["| published", "| recorded"]


def test_the_spread_of_targets_is_given_with_their_median() -> None:
    targets = [
        target(pairs=[9.9, 2.0, 12.0], jerk_cost=0.003),
        target(pairs=[18.0, 8.0, 20.0], true_jerk_cost=None),
        target(detection_px=2.0),
        target(frames=0, pairs=[None] * 3),
    ]
    cells = paper_tables.spreads(targets)
    assert cells[:3] == ("9.9 to 18.0 (12.0)", "2 of 3", "6 to 15")
    assert cells[3:6] == ("0.50 to 2.00 (0.50)", "0.40 to 0.40 (0.40)", "0.30 to 0.30 (0.30)")
    assert cells[6:] == ("0.00100 to 0.00300 (0.00100)", "0.00010 to 0.00010 (0.00010)")
    assert paper_tables.spreads([])[1] == "0 of 0"


def test_a_graph_file_that_is_the_only_one_is_there_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "compare.json"
    rooms = ["dev1", "dev2"]
    trials = [{"variant": "recorded", "room": room, "targets": {"red": target()}} for room in rooms]
    path.write_text(json.dumps({"variants": ["recorded"], "rooms": rooms, "trials": trials}))
    paper_tables.main(str(path))
    assert capsys.readouterr().out.count("| dev1 | recorded |") == 1
