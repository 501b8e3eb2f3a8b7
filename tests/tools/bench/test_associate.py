"""The benchmark of the association of people runs, and tells rate and accuracy of joints and boxes."""

from __future__ import annotations

import json
import sys

import pytest

import bench_associate


def test_rate_and_accuracy_of_joints_and_boxes_are_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["bench_associate.py", "--people", "2", "--frames", "6", "--json"])
    bench_associate.main()
    figures = json.loads(capsys.readouterr().out)
    assert set(figures) == {"points", "boxes"}
    for one in figures.values():
        assert one["sets_per_s"] > 0
        assert one["switches"] == 0
        assert one["mota"] > 0.5
    assert figures["points"]["correct_parts"] > 0.5
