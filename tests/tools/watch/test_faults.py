"""What is absent or old is told as such by `top`, `hz` and `echo`, with its age."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from tests.tools.watch.screens import on_terminal

from followspot.control.dispatch import NoAnswer, Request
from followspot.control.host import WorkerStatus
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.operator.run_handle import RunHandle
from followspot.operator.run_requests import GetPlan, GetStatus
from followspot.operator.run_status import RunStatus, SeenHost
from followspot.worker.ledger import COLUMNS
from followspot_dashboard.meter import Rhythm
from followspot_watch import hz
from followspot_watch.echo import Warner
from followspot_watch.run_monitor import RunMonitor
from followspot_watch.top import report, text

PLAN = compile_graph(Path(__file__).parents[3] / "graphs" / "glowballs.yaml", placement="stage")
FUSE = WorkerStatus(
    "fuse", "running", 7, stages=(StageStatus("fuse", "processing", fired=6, busy_ms=9.0),), age_s=0.1
)
SAVE = WorkerStatus("save", "running", 7, paths=(PathStatus("camera", "save", 1.5, 9.0),), age_s=0.1)
COUNTS = (0,) * (COLUMNS * len(PLAN.edges))
WELL = RunStatus((FUSE, SAVE), COUNTS, 7, None, hosts=(SeenHost("pc-left", 0.1, absent=False),))
GONE = replace(
    WELL,
    workers=(replace(FUSE, phase="absent", age_s=12.3, host="pc-left"), SAVE),
    hosts=(SeenHost("pc-left", 12.3, absent=True),),
)


def picture(*statuses: RunStatus, later: float = 0.0) -> RunMonitor:
    """After these statuses, a second apart, and some time, s."""
    now = [0.0]
    made = RunMonitor(PLAN, lambda: now[0])
    for status in statuses:
        made.take(status)
        now[0] += 1.0
    now[0] += later - 1.0
    return made


def stage(made: RunMonitor, name: str = "fuse") -> dict[str, object]:
    return next(stage for stage in made.data()["stages"] if stage["stage"] == name)


def run(status: Callable[[], RunStatus]) -> RunHandle:
    """A run that answers with its plan and this status."""

    def ask(request: Request, timeout: float) -> Any:
        if isinstance(request, GetPlan):
            return plan_to_data(PLAN)
        assert isinstance(request, GetStatus)
        return status()

    return RunHandle("run", PLAN.graph, ask)


def test_the_rate_of_a_stage_counts_the_seconds_between_its_own_reports() -> None:
    """Workers tell their stages every 0.6 s: two statuses a second apart hold 0.6 or 1.2 s of work."""

    def told(fired: int, ago: float) -> RunStatus:
        stages = (StageStatus("fuse", "processing", fired=fired, busy_ms=fired * 5.0),)
        return replace(WELL, workers=(replace(FUSE, stages=stages, stages_age_s=ago), SAVE))

    for fired, ago in ((60, 0.1), (30, 0.7)):
        seen = stage(picture(told(0, 0.3), told(fired, ago)))
        assert (seen["rate"], seen["load"]) == pytest.approx((50.0, 0.25), abs=1e-3)
    untold = stage(picture(told(30, 0.1), told(30, 1.1)))
    assert (untold["rate"], untold["load"]) == (0.0, 0.0)


def test_a_stage_whose_worker_is_absent_is_absent_and_has_no_rate() -> None:
    well, gone = stage(picture(WELL, WELL)), stage(picture(WELL, GONE))
    assert (well["state"], well["age_s"], well["rate"], well["load"]) == ("processing", None, 0.0, 0.0)
    assert (gone["state"], gone["age_s"], gone["rate"], gone["load"]) == ("absent", 12.3, None, None)
    assert gone["fired"] == 6
    quiet = replace(WELL, workers=(*WELL.workers, WorkerStatus("track", "starting")))
    assert stage(picture(quiet), "track")["state"] == "starting"
    old = {edge["to"]: edge["old"] for edge in picture(GONE).data()["edges"]}
    assert (old["fuse.candidates"], old["bridge.positions"], old["save.tracks"]) == (True, True, False)
    known = {found["stage"] for found in picture(WELL).data()["stages"]}
    assert known == {"fuse", "save"}  # on workers of another operator nobody has a word here


def test_a_stage_that_was_moved_does_what_it_does_at_its_new_place() -> None:
    left = replace(FUSE, name="left", phase="over", stages=(StageStatus("fuse", "processing", fired=90),))
    for workers in ((left, FUSE, SAVE), (FUSE, SAVE, left)):
        moved = stage(picture(replace(WELL, workers=workers)))
        assert (moved["worker"], moved["state"], moved["fired"]) == ("fuse", "processing", 6)


def test_what_a_run_that_does_not_answer_was_doing_is_old() -> None:
    made = picture(WELL, later=1.5)
    assert made.faults() == ("the run has not answered for 2 s",)
    assert (stage(made)["state"], stage(made)["age_s"]) == ("old", 1.6)
    assert {path["old"] for path in made.data()["paths"]} == {True}
    assert {edge["rate"] for edge in made.data()["edges"] if edge["from"] == "fuse.out"} == {None}


def test_the_last_status_of_a_run_that_has_ended_stays_and_of_one_that_is_silent_grows_old() -> None:
    def silent() -> RunStatus:
        raise NoAnswer("it is suspended")

    def ended() -> RunStatus:
        raise FollowspotError("the run does not answer")

    made = picture(WELL, later=5.0)
    made.renew(silent)
    assert (made.age_s, made.ended) == (5.0, False)
    made.renew(ended)
    assert (made.age_s, made.ended, made.faults()) == (0.0, True, ())


def test_top_marks_what_is_wrong_and_a_terminal_shows_it_red() -> None:
    data = {"graph": "g", "run": "0123456789", **picture(WELL, GONE).data()}
    lines = text(data).splitlines()
    assert lines[1] == "! host pc-left is absent: last heard 12 s ago"
    (fuse,) = [line for line in lines if line.split()[:2] == ["!", "fuse"]]
    assert fuse.split()[2:6] == ["fuse", "absent", "12", "s"]
    assert any(line.startswith("! fuse.out -> ") for line in lines)
    red = [line for line in on_terminal(partial(report, data), 300, 300) if "\x1b[1;31m" in line]
    assert [re.sub(r"\x1b\[[\d;]*m", "", line).rstrip() for line in red] == [
        line for line in lines if line.startswith("!")
    ]
    well = text({"graph": "g", "run": "0123456789", **picture(WELL, WELL).data()})
    assert "!" not in well


def test_top_says_what_a_change_waits_for() -> None:
    waiting = replace(WELL, change_awaits="host pc-left to build the new stages")
    line = "a change waits for host pc-left to build the new stages"
    told = [{"run": "12345678", "graph": "g", **picture(status).data()} for status in (WELL, waiting)]
    assert [line in text(data).splitlines() for data in told] == [False, True]


def test_hz_has_no_rate_of_a_port_whose_stage_is_absent_or_that_is_silent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(hz, "time", SimpleNamespace(monotonic=lambda: now[0]))
    status = [WELL]
    measured = hz.Measured(run(lambda: status[0]), ["fuse.out"])
    measured.take("fuse.out", Rhythm(100, 20.0, 50.0, 1.0, 60.0, 80.0))
    (pace,) = measured.paces()
    assert (pace.data()["rate"], pace.data()["stale"]) == (20.0, "")
    now[0] += 5.0
    (pace,) = measured.paces()
    assert (pace.data()["rate"], pace.data()["silent_s"]) == (None, 5.0)
    assert "silent for 5 s" in hz.text([pace])
    measured.take("fuse.out", Rhythm(3, 0.2, 5000.0, 0.0, 5000.0, 5000.0))  # one that rarely sends
    now[0] += 5.0
    assert measured.paces()[0].data()["rate"] == 0.2
    status[0] = GONE
    (pace,) = measured.paces()
    assert (pace.data()["rate"], pace.data()["stale"]) == (None, "absent")
    lines = hz.text([pace], measured.faults()).splitlines()
    assert lines[0] == "! host pc-left is absent: last heard 12 s ago"
    assert lines[2].startswith("! fuse.out ")


def test_echo_says_once_why_nothing_comes(capsys: pytest.CaptureFixture[str]) -> None:
    status = [WELL, GONE, GONE, WELL]
    warner = Warner(run(lambda: status.pop(0)))
    said = []
    for _ in range(4):
        warner.warn()
        said.append(capsys.readouterr().err)
    fault = "followspot: host pc-left is absent: last heard 12 s ago\n"
    assert said == ["", fault, "", "followspot: all hosts and workers answer again\n"]
