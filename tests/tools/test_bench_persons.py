"""The benchmark of the fast instance runs, and tells how many people it followed."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

import bench_persons

ROOM = Path(__file__).parent.parent.parent / "graphs/rooms/simulated_panorama.yaml"


@pytest.mark.thorough
def test_frames_a_second_are_told_with_particles_and_people(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    size = "--frames 6 --every 2 --particles 40 --json"
    monkeypatch.setattr(sys, "argv", ["bench_persons.py", "--room", str(ROOM), *size.split()])
    bench_persons.main()
    figures = json.loads(capsys.readouterr().out)
    assert figures["size"] == [1396, 260]
    assert figures["frames"] == 6
    assert figures["particles"] == 40
    assert figures["persons"] > 0
    assert figures["frames_per_s"] == pytest.approx(
        1000 / (figures["gradients_ms"] + figures["pose_tracker_ms"])
    )
