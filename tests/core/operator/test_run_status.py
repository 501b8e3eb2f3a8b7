"""Ages and faults in the status of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from followspot.control.dispatch import answer_from_wire, answer_to_wire
from followspot.control.host import HostStatus, WorkerPhase, WorkerStatus
from followspot.control.observation import GetHostStatus
from followspot.control.stage_status import StageState, StageStatus
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedWorker
from followspot.operator.run_requests import GetStatus
from followspot.operator.run_status import RunStatus, SeenHost
from followspot.operator.run_view import RunView

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
LEFT = WorkerStatus("left", "running", 7, age_s=0.25, stages_age_s=0.5)


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    (tmp_path / "g.yaml").write_text("graph: g\nstages:\n  a: {uses: ticks.count}\n")
    workers = (PlannedWorker("left", "pc-left"), PlannedWorker("main"))
    return replace(compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS]), workers=workers)


def seen(plan: Plan, age_s: float | None, *workers: WorkerStatus) -> RunStatus:
    """The status of a run whose host pc-left answered `age_s` ago, None for never."""
    near = HostStatus((WorkerStatus("main", "running", age_s=0.0),), (), age_s=0.0)
    return RunView(plan, {"": near, "pc-left": HostStatus(workers, (), age_s=age_s)}).status()


def worker(status: RunStatus, name: str = "left") -> WorkerStatus:
    return next(worker for worker in status.workers if worker.name == name)


def test_the_age_of_a_worker_includes_the_age_of_its_hosts_status(plan: Plan) -> None:
    status = seen(plan, 0.5, LEFT)
    assert worker(status) == replace(LEFT, age_s=0.75, stages_age_s=1.0, host="pc-left")
    assert status.hosts == (SeenHost("pc-left", 0.5, absent=False),)
    assert status.faults() == ()


def test_workers_of_a_silent_host_are_absent_and_keep_their_figures(plan: Plan) -> None:
    status = seen(plan, 12.0, LEFT)
    assert worker(status) == replace(LEFT, phase="absent", age_s=12.25, stages_age_s=12.5, host="pc-left")
    assert status.hosts == (SeenHost("pc-left", 12.0, absent=True),)
    assert status.faults() == ("host pc-left is absent: last heard 12 s ago",)


def test_a_host_is_old_before_it_is_absent(plan: Plan) -> None:
    status = seen(plan, 1.25, LEFT)
    assert worker(status).phase == "running"
    assert status.faults() == ("host pc-left was last heard 1.2 s ago",)


def test_ended_workers_are_no_fault(plan: Plan) -> None:
    over = replace(LEFT, phase="over")
    status = seen(plan, 60.0, over)
    assert worker(status).phase == "over"
    assert status.hosts == status.faults() == ()


def test_an_unlisted_worker_is_starting_or_its_host_is_out_of_reach(plan: Plan) -> None:
    assert worker(seen(plan, None)).phase == "starting"
    assert seen(plan, None).faults() == ()
    away = RunView(plan, {"pc-left": HostStatus((), ())}, begun=True).status()
    assert (worker(away).phase, worker(away).age_s) == ("absent", None)
    assert away.faults() == ("host pc-left is absent: nothing is heard of the run there",)
    assert len(away.workers) == 1  # the workers of the operator's own host are unknown here


@pytest.mark.parametrize(
    ("phase", "restarts", "age_s", "fault"),
    [
        ("running", 0, 0.9, ""),
        ("running", 0, 1.5, "worker left was last heard 1.5 s ago"),
        ("absent", 0, 3.0, "worker left is absent: last heard 3 s ago"),
        ("starting", 0, 9.0, ""),
        ("starting", 1, 0.1, "worker left is starting again"),
        ("over", 2, 60.0, ""),
    ],
)
def test_an_old_or_absent_worker_is_a_fault(
    plan: Plan, phase: WorkerPhase, restarts: int, age_s: float, fault: str
) -> None:
    status = seen(plan, 0.0, replace(LEFT, phase=phase, restarts=restarts, age_s=age_s))
    assert status.faults() == ((fault,) if fault else ())


def awaited(plan: Plan, near: StageState, far: HostStatus, expected: int | None = 9) -> tuple[str, ...]:
    """The hosts that a run waits for if its sources are `a` on pc-left, as `far` says, and `b` here."""
    main = WorkerStatus("main", "running", expected=expected, stages=(StageStatus("b", near),), age_s=0.0)
    return RunView(plan, {"": HostStatus((main,), (), age_s=0.0), "pc-left": far}, begun=True).awaited()


def test_a_run_that_would_end_waits_for_silent_hosts_alone_once_other_sources_have_ended(plan: Plan) -> None:
    a, b = plan.stages[0], replace(plan.stages[0], name="b", worker="main")
    plan = replace(plan, stages=(replace(a, worker="left"), b))
    silent, heard = HostStatus((LEFT,), (), age_s=9.0), HostStatus((LEFT,), (), age_s=0.1)
    assert awaited(plan, "over", silent) == ("pc-left",)
    assert awaited(plan, "getting", silent) == ()
    assert awaited(plan, "over", heard) == ()
    assert awaited(plan, "over", silent, expected=None) == ()
    ended = HostStatus((replace(LEFT, phase="over"),), (), age_s=9.0)
    assert awaited(plan, "over", ended) == ()


def test_later_changes_only_the_ages_of_a_status(plan: Plan) -> None:
    now = seen(plan, 0.5, LEFT)
    later = now.later(1.5)
    assert worker(later) == replace(worker(now), age_s=2.25, stages_age_s=2.5)
    assert later.hosts == (SeenHost("pc-left", 2.0, absent=False),)  # only its age has changed
    assert answer_from_wire(GetStatus, answer_to_wire(GetStatus, later)) == later


@pytest.mark.parametrize("age", [-1.0, float("nan"), float("inf")])
def test_an_invalid_age_is_rejected(age: float) -> None:
    data = answer_to_wire(GetHostStatus, HostStatus((LEFT,), (), age_s=0.0))
    data["workers"][0]["age_s"] = age
    with pytest.raises(ValueError, match="age_s"):
        answer_from_wire(GetHostStatus, data)
