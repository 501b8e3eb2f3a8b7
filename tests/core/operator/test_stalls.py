"""An edge stalls if its writer has no room to send while its reader waits for it; all else is work."""

from __future__ import annotations

from dataclasses import replace

import pytest

from followspot.control.host import HostStatus, WorkerPhase, WorkerStatus
from followspot.control.stage_status import StageState, StageStatus
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.operator.run_view import RunView
from followspot.room import Room

EDGE = "more.out -> sum.numbers"
MORE = StageStatus("more", "sending", (EDGE,), idle_s=9.0)
SUM = StageStatus("sum", "getting", ("less.out -> sum.numbers", EDGE))
PLAN = Plan(
    "toy",
    Room(),
    tuple(PlannedStage(name, name, "toy.stage", {}, None, name, live=False) for name in ("more", "sum")),
    (PlannedEdge("more", "out", "sum", "numbers", "zenoh"),),
    (PlannedWorker("more"), PlannedWorker("sum")),
)


def faults(writer: StageStatus, reader: StageStatus, phase: WorkerPhase = "running") -> tuple[str, ...]:
    """What a run says of these two, each in its own worker."""
    workers = (
        WorkerStatus("more", phase, stages=(writer,), age_s=0.1),
        WorkerStatus("sum", "running", stages=(reader,), age_s=0.1),
    )
    view = RunView(PLAN, {"": HostStatus(workers, (), age_s=0.1)}, begun=True)
    assert view.progress().faults == view.status().faults()
    return view.stalled()


def test_an_edge_stalls_whose_ends_wait_for_each_other() -> None:
    line = f"{EDGE} stalls: more has had no room to send for 9 s, though sum waits for its messages"
    assert faults(MORE, SUM) == (line,)


@pytest.mark.parametrize("state", ["processing", "waiting", "sending", "paused", "over"])
def test_a_reader_that_works_or_is_held_does_not_stall(state: StageState) -> None:
    assert faults(MORE, replace(SUM, state=state)) == ()


def test_other_waits_are_no_stalls() -> None:
    assert faults(replace(MORE, idle_s=1.0), SUM) == ()
    assert faults(replace(MORE, state="getting"), SUM) == ()
    assert faults(replace(MORE, on=("more.out -> other.number",)), SUM) == ()
    assert faults(MORE, replace(SUM, on=("less.out -> sum.numbers",))) == ()
    assert faults(MORE, SUM, "absent") == ()
