"""The coordinator before the start of a run: observers can already read its status and place taps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from tests.core.worker.pair import PAIR, TICKS

from followspot.control.dispatch import Request
from followspot.control.host import HostLost, HostStatus, RunOrder, WorkerStatus
from followspot.control.lifecycle import StopRun
from followspot.control.tapping import PlaceTaps, Tapping
from followspot.control.worker_report import WorkerReport
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.host.local_host import LocalHost
from followspot.log.run_log import RunLog
from followspot.operator.coordinator import Coordinator
from followspot.operator.new_order import new_order
from followspot.operator.run_dispatcher import run_dispatcher
from followspot.operator.run_requests import ChangeStages, MoveStages, RunMetadata
from followspot.worker.ledger import COLUMNS
from followspot.worker.wiring import RunOptions


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    (tmp_path / "g.yaml").write_text(PAIR)
    return compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS])


def order(plan: Plan) -> RunOrder:
    return new_order(plan, RunOptions(), restart=False)


class Ready:
    """A host whose workers are ready once it is prepared, and that takes taps from then on."""

    name = ""

    def __init__(self) -> None:
        self.log = RunLog()
        self.workers: tuple[WorkerStatus, ...] = ()
        self.taps: list[Tapping] = []

    def prepare(self, order: RunOrder) -> None:
        self.workers = (WorkerStatus("a", "ready"), WorkerStatus("b", "ready"))

    def ask(self, request: Request) -> None:
        """Begin, or take taps."""
        if isinstance(request, PlaceTaps):
            assert self.workers, "there is nothing to look at"
            self.taps += request.taps

    def status(self) -> HostStatus:
        return HostStatus(self.workers, ())


def test_taps_placed_before_the_start_reach_the_host_once_it_is_prepared(plan: Plan) -> None:
    host, taps = Ready(), [Tapping(f"a.{name}", "dashboard.tap", {}) for name in ("first", "second")]
    run = Coordinator(plan, [host], order(plan))  # type: ignore[list-item]
    run.relay(PlaceTaps(taps=tuple(taps[:1])))
    assert host.taps == []
    assert run.begin()
    assert host.taps == taps[:1]
    run.relay(PlaceTaps(taps=tuple(taps[1:])))
    assert host.taps == taps


def test_a_run_that_has_not_begun_refuses_changes(plan: Plan) -> None:
    run = Coordinator(plan, [LocalHost("")], order(plan))
    for request in (ChangeStages(words=("a.count=7",)), MoveStages(stages=("a",), place="b")):
        with pytest.raises(FollowspotError, match="has not begun yet"):
            run_dispatcher(run, RunMetadata()).dispatch(request)
    assert [(w.name, w.phase) for w in run.status().workers] == [("a", "starting"), ("b", "starting")]


def test_a_status_is_available_while_workers_start() -> None:
    """Another thread may read the status: here a worker is added while the first one's status is read."""
    host, workers = LocalHost(""), {}

    def status() -> WorkerStatus:
        workers["b"] = workers["a"]
        return WorkerStatus("a", "starting")

    workers["a"] = SimpleNamespace(status=status)
    host.pool = SimpleNamespace(workers=workers, plan=SimpleNamespace(rows=0))  # type: ignore[assignment]
    assert [worker.name for worker in host.status().workers] == ["a"]


class Lasting(Ready):
    """A host with one worker that works until it is told to stop, and some polls more."""

    def __init__(self, name: str, worker: str, lasts: int = 5) -> None:
        super().__init__()
        self.name, self.worker, self.lasts, self.stopping = name, worker, lasts, False

    def prepare(self, order: RunOrder) -> None:
        self.workers = (WorkerStatus(self.worker, "ready"),)

    def ask(self, request: Request) -> None:
        """Begin, or stop."""
        self.stopping |= isinstance(request, StopRun)

    def attend(self, seconds: float) -> None:
        self.lasts -= self.stopping
        if not self.lasts:
            self.end()

    def end(self) -> None:
        self.workers = (WorkerStatus(self.worker, "over", report=WorkerReport(self.worker, 3)),)

    def status(self) -> HostStatus:
        return HostStatus(self.workers, (0,) * COLUMNS)


class Away(Lasting):
    """A host that does not answer once: in the run, while it stops, or when its own worker has ended."""

    def __init__(self, when: str) -> None:
        super().__init__("far", "b", lasts=3)
        self.when, self.polls, self.away = when, 0, False

    def attend(self, seconds: float) -> None:
        self.polls += 1
        if self.when == "over":
            self.end()
        if self.polls == 2:
            self.away = True
            raise HostLost("host far does not answer")
        super().attend(seconds)


@pytest.mark.parametrize(
    ("when", "fails"), [("in the run", True), ("while it stops", False), ("over", False)]
)
def test_a_run_without_restarts_fails_if_the_silence_of_a_host_cut_it_short(
    plan: Plan, when: str, fails: bool
) -> None:
    """Though the host comes back, and all come to a clean end."""
    apart = [replace(worker, host={"b": "far"}.get(worker.name, "")) for worker in plan.workers]
    far, near = Away(when), Lasting("", "a")
    run = Coordinator(replace(plan, workers=tuple(apart)), [far, near], order(plan))  # type: ignore[list-item]
    assert run.begin()
    if when == "while it stops":
        run.stop()
    cut_short = []

    def look(*_: object) -> None:
        if when == "over" and far.polls == 4:
            cut_short.append(near.stopping)
            run.stop()

    report = run.watch(look)
    assert far.away
    assert cut_short == [False] * (when == "over")
    assert [error.partition(":")[0] for error in report.errors] == ["host far does not answer"] * fails
    assert far.polls > 4


class Robbed(Lasting):
    """A host whose run another operator ends, which is known when the last poll is over."""

    gone = False

    def attend(self, seconds: float) -> None:
        if self.gone:
            raise HostLost("host far no longer has the run")
        self.gone = True
        self.workers = (WorkerStatus(self.worker, "over"),)


def test_why_a_host_has_no_report_is_told_though_it_is_known_only_at_the_end(plan: Plan) -> None:
    apart = [replace(worker, host={"b": "far"}.get(worker.name, "")) for worker in plan.workers]
    near = Lasting("", "a", lasts=1)
    hosts = [near, Robbed("far", "b")]
    run = Coordinator(replace(plan, workers=tuple(apart)), hosts, order(plan))  # type: ignore[arg-type]
    assert run.begin()
    near.end()
    report = run.watch()
    assert report.errors == ("worker b was not there at the end: host far no longer has the run",)
