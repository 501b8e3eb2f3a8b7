"""Workers count the messages of a path that took longer than its budget."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.messages import Header
from followspot.worker.latency import LatencyHistogram, PathLatencies

MS = 1_000_000
PLUGIN = """
import time
from followspot import Outputs, Source, Stage, at
from followspot.tracking import Tracks

class Ticking(Stage):
    def process(self) -> Source[Tracks]:
        for number in range(3):
            yield at(number, Tracks.empty())

class Slow(Stage):
    def process(self, tracks: Tracks) -> Tracks:
        time.sleep(0.03)
        return Tracks.empty()

class Twice(Stage):
    def process(self, tracks: Tracks) -> Outputs[Tracks]:
        yield Tracks.empty()

class Ends(Stage):
    def process(self, tracks: Tracks) -> None:
        pass
"""


def test_a_message_is_late_if_it_takes_longer_than_the_budget() -> None:
    path = LatencyHistogram(limit=20 * MS)
    for elapsed in [19 * MS, 20 * MS, 20 * MS + 1, 90 * MS]:
        path.add(elapsed, "camera/cam0", 0)
    status, summary = path.status("camera", "track"), path.summary("camera", "track")
    assert (status.count, status.budget_ms, status.late, status.recent_ms) == (4, 20.0, 2, None)
    assert (summary.budget_ms, summary.late) == (20.0, 2)


def test_whether_it_is_kept_now_goes_by_the_newest_hundred() -> None:
    path = LatencyHistogram(limit=20 * MS)
    for elapsed in [90 * MS] * 500 + [5 * MS] * 95 + [70 * MS] * 5:
        path.add(elapsed, "camera/cam0", 0)
    assert path.status("camera", "track").recent_ms == 5.0
    path.add(70 * MS, "camera/cam0", 0)
    assert path.status("camera", "track").recent_ms == 70.0


def test_a_path_without_a_budget_keeps_no_latencies() -> None:
    path = LatencyHistogram()
    path.add(5 * MS, "camera/cam0", 0)
    status = path.status("camera", "save")
    assert (status.count, status.budget_ms, status.late, status.recent_ms) == (1, None, 0, None)
    assert not path.newest


def test_a_stage_that_is_no_sink_notes_only_paths_with_a_budget() -> None:
    paths = PathLatencies({"camera/cam0": "camera", "imu/a": "imu"}, {"camera": 20 * MS})
    paths.add_budgeted(Header("camera/cam0", 1, 0, 0), 30 * MS)
    paths.add_budgeted(Header("imu/a", 1, 0, 0), 30 * MS)
    assert set(paths) == {"camera"}
    assert paths["camera"].late == 1


def test_a_slow_stage_that_misses_a_budget_is_named_at_the_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "budgeted.py").write_text(PLUGIN)
    (tmp_path / "room.yaml").write_text("room: empty\n")
    (tmp_path / "graph.yaml").write_text(
        "graph: slow\nroom: room.yaml\nstages:\n"
        "  ticks: {uses: budgeted.ticking}\n"
        "  slow: {uses: budgeted.slow, in: {tracks: ticks}}\n"
        "  twice: {uses: budgeted.twice, in: {tracks: slow}}\n"
        "  end: {uses: budgeted.ends, in: {tracks: twice}}\n"
    )
    (tmp_path / "budget.yaml").write_text(
        "budget: {ticks -> slow: 10 ms, ticks -> twice: 20 ms, ticks -> end: 60 s}\n"
    )
    words = ["--plugin", str(tmp_path / "budgeted.py"), "--placement", str(tmp_path / "budget.yaml")]
    assert main(["run", str(tmp_path / "graph.yaml"), *words, "--out", str(tmp_path), "-q", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    paths = {(path["from"], path["to"]): (path["budget_ms"], path["late"]) for path in told["paths"]}
    assert paths == {("ticks", "slow"): (10, 3), ("ticks", "twice"): (20, 3), ("ticks", "end"): (60_000, 0)}
    first, second = told["warnings"]
    assert "ticks -> slow missed its budget of 10 ms with 3 of 3 messages; " in first
    assert "ticks -> twice missed its budget of 20 ms with 3 of 3 messages; " in second
    assert "slow" in second.partition(";")[2]
