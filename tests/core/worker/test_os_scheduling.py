"""A worker asks its host for cores and priority; what the host refuses is told, and the worker goes on."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.graph.scheduling import Scheduling
from followspot.worker.os_scheduling import apply_scheduling

PLUGIN = """
import os
from pathlib import Path
from followspot import Source, Stage, at
from followspot.tracking import Tracks

class Ticks(Stage):
    def process(self) -> Source[Tracks]:
        yield at(0, Tracks.empty())

class Asks(Stage):
    def process(self, tracks: Tracks) -> None:
        told = sorted(os.sched_getaffinity(0)), os.getpriority(os.PRIO_PROCESS, 0)
        (Path(self.context.out) / "told.txt").write_text(repr(told))
"""


def in_a_thread(work: Callable[[], list[object]]) -> list[object]:
    """What it returns; what it changes of its thread's scheduling ends with the thread."""
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.extend(work()))
    thread.start()
    thread.join()
    return found


def test_cores_and_priority_are_those_of_the_thread() -> None:
    core = max(os.sched_getaffinity(0))
    lower = min(os.getpriority(os.PRIO_PROCESS, 0) + 3, 19)  # the tests themselves may run at a low priority
    wanted = Scheduling((core,), lower)

    def work() -> list[object]:
        refused = list(apply_scheduling(wanted))
        return [refused, os.sched_getaffinity(0), os.getpriority(os.PRIO_PROCESS, 0)]

    before = os.sched_getaffinity(0), os.getpriority(os.PRIO_PROCESS, 0)
    assert in_a_thread(work) == [[], {core}, lower]
    assert (os.sched_getaffinity(0), os.getpriority(os.PRIO_PROCESS, 0)) == before


def test_cores_that_are_not_there_are_told_and_the_others_are_used() -> None:
    core = max(os.sched_getaffinity(0))

    def work() -> list[object]:
        return [*apply_scheduling(Scheduling((1023, core))), os.sched_getaffinity(0)]

    refused, cores = in_a_thread(work)
    assert "no core 1023 for it here; it keeps to the others" in str(refused)
    assert cores == {core}


def test_without_any_core_that_is_there_all_are_used() -> None:
    before = os.sched_getaffinity(0)
    (refused,) = in_a_thread(lambda: list(apply_scheduling(Scheduling((1023,)))))
    assert "no core 1023 for it here\n" in str(refused)
    assert os.sched_getaffinity(0) == before


def test_a_host_that_lacks_the_right_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "setpriority", refuse)
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    (nice,) = apply_scheduling(Scheduling(nice=-5))
    (realtime,) = apply_scheduling(Scheduling(realtime=10))
    assert nice.startswith("nice -5 is not allowed here (Operation not permitted)")
    assert realtime.startswith("real-time priority 10 is not allowed here, so the worker is an ordinary one")
    assert "CAP_SYS_NICE" in nice
    assert "CAP_SYS_NICE" in realtime


def test_real_time_is_for_the_thread_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int, int]] = []
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda pid, policy, given: asked.append((pid, policy, given.sched_priority))
    )
    assert list(apply_scheduling(Scheduling(realtime=10))) == []
    assert asked == [(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, 10)]


def test_a_stage_runs_where_its_placement_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    core = max(os.sched_getaffinity(0))
    (tmp_path / "asking.py").write_text(PLUGIN)
    (tmp_path / "room.yaml").write_text("room: empty\n")
    (tmp_path / "graph.yaml").write_text(
        "graph: ask\nroom: room.yaml\nstages:\n"
        "  ticks: {uses: asking.ticks}\n  ask: {uses: asking.asks, in: {tracks: ticks}}\n"
    )
    (tmp_path / "placed.yaml").write_text(
        f"workers: {{w: {{stages: [ask], cores: [{core}, 1023], nice: 19}}}}\n"
    )
    words = ["--plugin", str(tmp_path / "asking.py"), "--placement", str(tmp_path / "placed.yaml")]
    assert (
        main(["run", str(tmp_path / "graph.yaml"), *words, "--out", str(tmp_path), "--quiet", "--json"]) == 0
    )
    assert (tmp_path / "told.txt").read_text() == f"([{core}], 19)"
    (warning,) = json.loads(capsys.readouterr().out)["warnings"]
    assert "worker w: there is no core 1023" in warning
