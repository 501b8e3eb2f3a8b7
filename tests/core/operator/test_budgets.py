"""Which paths miss their budgets, and what takes the time there; all times are given, none is measured."""

from __future__ import annotations

from dataclasses import replace

from followspot.control.host import HostStatus, WorkerStatus
from followspot.control.stage_status import EdgeAge, PathStatus, StageStatus
from followspot.graph.budget import Budget
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.operator.budgets import largest_part, missed_budgets, overruns
from followspot.operator.fault_watch import FaultWatch
from followspot.operator.run_view import RunView
from followspot.room import Room

CHAIN = ("camera", "detect", "fuse", "track")


def stage(name: str, group: str) -> PlannedStage:
    return PlannedStage(name, group, "toy.stage", {}, None, "main", live=False)


def edge(start: str, end: str, delay: int = 0) -> PlannedEdge:
    return PlannedEdge(start, "out", end, "input", "reference", delay)


PLAN = Plan(
    "toy",
    Room(),
    tuple(stage(name, name) for name in (*CHAIN, "other")),
    (*map(edge, CHAIN, CHAIN[1:]), edge("track", "detect", 1), edge("camera", "other")),
    (PlannedWorker("main"),),
    budgets=(Budget("camera", "track", 0.02),),
)


def figures(work: dict[str, float], ages: dict[str, float]) -> dict[str, StageStatus]:
    """Stages that fired ten times; work: ms each; ages: p95, ms, at the input of each; feedback is old."""
    into = {edge.to_stage: edge.name for edge in PLAN.edges if not edge.delay}
    back = EdgeAge("track.out -> detect.input", 900.0, 900.0)
    return {
        name: StageStatus(
            name,
            "waiting",
            fired=10,
            busy_ms=10 * work.get(name, 0.0),
            edges=(EdgeAge(into[name], ages[name], ages[name]), back) if name in ages else (),
        )
        for name in (*CHAIN, "other")
    }


def running(stages: dict[str, StageStatus], recent: float | None, late: int = 0) -> WorkerStatus:
    path = PathStatus("camera", "track", 1.0, 1.0, 100, 20.0, late, recent)
    return WorkerStatus("main", "running", stages=tuple(stages.values()), paths=(path,), age_s=0.0)


SLOW_FUSE = figures(
    {"detect": 3.0, "fuse": 12.0, "track": 1.0, "other": 90.0}, {"detect": 0.5, "fuse": 4.0, "track": 16.5}
)
SLOW_HOP = figures({"detect": 3.0, "fuse": 2.0, "track": 1.0}, {"detect": 0.5, "fuse": 24.0, "track": 26.5})


def test_the_stage_that_works_longest_on_the_path_is_named() -> None:
    part = largest_part(PLAN, "camera", "track", SLOW_FUSE)
    assert part is not None
    assert (part.ms, part.text) == (12.0, "fuse works 12.0 ms")


def test_a_wait_is_what_inputs_and_work_of_the_sender_do_not_explain() -> None:
    part = largest_part(PLAN, "camera", "track", SLOW_HOP)
    assert part is not None
    assert part.ms == 24.0 - (0.5 + 3.0)
    assert part.text == "messages wait 20.5 ms before fuse, which works 2.0 ms on each"


def test_nothing_is_named_before_anything_is_known() -> None:
    assert largest_part(PLAN, "camera", "track", {}) is None


def test_a_path_whose_newest_messages_are_late_is_missed_and_another_is_not() -> None:
    (line,) = missed_budgets(PLAN, [running(SLOW_FUSE, 23.4)])
    assert line == (
        "camera -> track misses its budget of 20 ms: 95 % of the newest messages take up to 23.4 ms;"
        " fuse works 12.0 ms"
    )
    assert not list(missed_budgets(PLAN, [running(SLOW_FUSE, 19.9)]))
    assert not list(missed_budgets(PLAN, [running(SLOW_FUSE, None)]))
    assert not list(missed_budgets(replace(PLAN, budgets=()), [running(SLOW_FUSE, 23.4)]))


def test_a_run_that_has_ended_tells_how_many_were_late() -> None:
    ended = replace(running(SLOW_HOP, 23.4, late=7), phase="over")
    assert not list(missed_budgets(PLAN, [ended]))
    (line,) = overruns(PLAN, [ended])
    assert line.startswith("camera -> track missed its budget of 20 ms with 7 of 100 messages; messages wait")
    assert not list(overruns(PLAN, [running(SLOW_HOP, 23.4, late=0)]))


def test_status_progress_and_faults_tell_it() -> None:
    view = RunView(PLAN, {"": HostStatus((running(SLOW_FUSE, 23.4),), (), age_s=0.0)}, begun=True)
    (fault,) = view.status().faults()
    assert "camera -> track misses its budget" in fault
    assert view.progress().faults == (fault,)


def test_a_miss_is_told_when_it_begins_and_when_it_ends() -> None:
    watch = FaultWatch(" misses its", " keeps its")
    assert not list(watch.changes([]))
    assert list(watch.changes(["a -> b misses its budget of 2 ms: 95 % up to 3 ms"])) == [
        ("a -> b misses its budget of 2 ms: 95 % up to 3 ms", True)
    ]
    assert not list(watch.changes(["a -> b misses its budget of 2 ms: 95 % up to 4 ms"]))
    assert list(watch.changes([])) == [("a -> b keeps its budget of 2 ms again", False)]
