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
    first, second = capsys.readouterr().out.strip().split("\n\n")
    assert [line.split(" | ")[0] for line in first.splitlines()[2:]] == [f"| {v}" for v in variants]
    assert len(second.splitlines()) == 2 + 4
    assert second.splitlines()[2].startswith("| dev1 | published | 90.0 % |")
