"""Each part of the time from capture to track has one cause, and together they are all of it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from bench.runtime import live_latency
from benching.live_paths import DECODING, FORECAST, HOPS, LATE, OTHERS, RUNTIME, STAGES, Trace
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.room import Room


def plan() -> Plan:
    """Two cameras with a detector each, one of them in another worker than the fusion, and feedback."""
    places = {"cam0": "main", "cam1": "far", "find0": "main", "find1": "far", "fuse": "main"}
    stages = tuple(
        PlannedStage(name, name, "", {}, None, worker, live=False) for name, worker in places.items()
    )
    edges = (
        PlannedEdge("cam0", "out", "find0", "frame", "reference"),
        PlannedEdge("cam1", "out", "find1", "frame", "reference"),
        PlannedEdge("find0", "out", "fuse", "blobs", "reference"),
        PlannedEdge("find1", "out", "fuse", "blobs", "ring"),
        PlannedEdge("fuse", "out", "find0", "forecast", "reference", delay=1),
        PlannedEdge("fuse", "out", "find1", "forecast", "ring", delay=1),
    )
    return Plan("g", Room(), stages, edges, (PlannedWorker("main"), PlannedWorker("far")))


MAIN = {
    "frames": [("cam0", 1, 0, 1), ("cam0", 1, 0, 2), ("cam0", 2, 100, 101)],
    "decoded": [("cam0", 40, 60)],
    "fired": [
        ("find0", 1, 3, 9, 10),
        ("fuse", 1, 70, 80, 88),
        ("find0", 2, 103, 109, 110),
        ("fuse", 2, 150, 160, 161),
    ],
    "arrived": [
        *[("cam0.out -> find0.frame", 1, 2), ("find0.out -> fuse.blobs", 1, 10)],
        *[("find1.out -> fuse.blobs", 1, 65), ("fuse.out -> find0.forecast", 1, 82)],
        *[("cam0.out -> find0.frame", 2, 102), ("find0.out -> fuse.blobs", 2, 110)],
        *[("find1.out -> fuse.blobs", 2, 148), ("fuse.out -> find0.forecast", 2, 161)],
    ],
    "waited": [(2, 50), (10, 51), (60, 54), (65, 58), (88, 60), (148, 61), (160, 64)],
}
FAR = {
    "frames": [("cam1", 1, 0, 5), ("cam1", 2, 100, 104)],
    "decoded": [("cam1", 2, 4)],
    "fired": [("find1", 1, 8, 30, 31), ("find1", 2, 122, 140, 141)],
    "arrived": [
        *[("cam1.out -> find1.frame", 1, 7), ("fuse.out -> find1.forecast", 1, 120)],
        ("cam1.out -> find1.frame", 2, 105),
    ],
    "waited": [(1, 0), (5, 4), (31, 5), (104, 99), (120, 100), (140, 107)],
}


def test_each_nanosecond_has_the_cause_that_the_notes_tell(tmp_path: Path) -> None:
    for name, notes in (("1", MAIN), ("2", FAR)):
        (tmp_path / f"{name}.json").write_text(json.dumps(notes))
    first, second = Trace(tmp_path, plan()).ways("fuse", 0)
    # 0 due, 5 entered while decoding took 2; 7 at the detector, at work from 8 to 30; 65 at the fusion, whose
    # worker decoded from 40 to 60; at work from 70 to 80, and sent at 88
    assert (first.hops, first.total) == (1, 88)
    assert first.parts == {STAGES: 32, OTHERS: 0, DECODING: 22, FORECAST: 0, HOPS: 15, LATE: 3, RUNTIME: 16}
    # 4 until the frame entered, 0 until its blobs were found, 7 at the fusion
    assert first.waited == 4 + 0 + 7
    # 105 at the detector, which waits for the forecast until 120
    assert (second.hops, second.total) == (1, 61)
    assert second.parts == {STAGES: 28, OTHERS: 0, DECODING: 0, FORECAST: 15, HOPS: 8, LATE: 4, RUNTIME: 6}
    assert second.waited == 4 + 8 + 4, "no longer than the time itself"
    assert len(Trace(tmp_path, plan()).ways("fuse", 1)) == 1


def test_what_a_worker_does_meanwhile_is_told_from_what_it_waits_for(tmp_path: Path) -> None:
    busy = {**MAIN, "fired": [*MAIN["fired"], ("find0", 3, 28, 36, 39), ("find0", 4, 34, 38, 39)]}
    for name, notes in (("1", busy), ("2", FAR)):
        (tmp_path / f"{name}.json").write_text(json.dumps(notes))
    (first,) = Trace(tmp_path, plan()).ways("fuse", 0)[:1]
    assert first.parts[OTHERS] == 8, "from 30 to 38: firings that overlap count once"
    assert first.total == 88


def test_a_live_run_is_traced_over_its_workers(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--rates", "100", "--rounds", "1", "--frames", "13", "--json", "--placements"]
    monkeypatch.setattr(sys, "argv", ["live_latency.py", *words, "one worker", "camera"])
    live_latency.main()
    one, apart = json.loads(capsys.readouterr().out)
    assert (one["placement"], one["hops"], one["parts"][HOPS]) == ("one worker", 0.0, 0.0)
    # every camera's blobs go to the worker of the fusion, whichever come last
    assert apart["hops"] >= 1
    assert apart["parts"][HOPS] > 0
    for row in (one, apart):
        assert sum(row["parts"].values()) == pytest.approx(row["mean"])
        assert 0 <= row["no_core"] <= row["mean"]
        assert min(row["parts"].values()) >= 0 < row["parts"][STAGES]
