"""A live run on one host: moves that nobody ends, and frames that are counted through deaths."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from followspot.control.lifecycle import StartRun
from followspot.control.move import MoveOrder
from followspot.errors import FollowspotError
from followspot.graph.change.move import plan_after_move
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.host.local_host import LocalHost
from followspot.operator.new_order import new_order
from followspot.worker.wiring import RunOptions

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a: {uses: ticks.live, with: {count: 1000000}}
  b: {uses: ticks.tally, in: {number: a}}
  c: {uses: ticks.tally, in: {number: b}}
"""


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    (tmp_path / "g.yaml").write_text(GRAPH)
    return compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS])


@pytest.fixture
def host(tmp_path: Path, plan: Plan) -> Iterator[LocalHost]:
    made = LocalHost("")
    made.prepare(new_order(plan, RunOptions(tmp_path), restart=True))
    attend(made, lambda: made.status().all("ready"))
    made.ask(StartRun())
    attend(made, lambda: made.status().all("running"))
    yield made
    made.close()


def attend(host: LocalHost, until: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 60.0  # bounds a failure only
    while not until():
        assert time.monotonic() < deadline, host.status()
        host.attend(0.02)


def phases(host: LocalHost) -> dict[str, str]:
    return {worker.name: worker.phase for worker in host.status().workers}


def frames(host: LocalHost) -> dict[str, int]:
    return {worker.name: worker.fired for worker in host.status().workers}


def test_the_frames_of_a_worker_are_counted_through_its_deaths(host: LocalHost, tmp_path: Path) -> None:
    for _ in range(2):
        before = frames(host)["c"]
        attend(host, lambda: frames(host)["c"] > before + 5)  # noqa: B023  # of this round
        before = frames(host)["c"]
        host.workers["c"].process.kill()
        attend(host, lambda: phases(host)["c"] == "absent")
        assert frames(host)["c"] >= before
        attend(host, lambda: phases(host)["c"] == "running")
        assert frames(host)["c"] >= before


def test_a_worker_that_nothing_replaces_is_named_once_if_it_is_suspended(plan: Plan, tmp_path: Path) -> None:
    host = LocalHost("")
    host.prepare(new_order(plan, RunOptions(tmp_path), restart=False))
    attend(host, lambda: host.status().all("ready"))
    host.ask(StartRun())
    attend(host, lambda: host.status().all("running"))
    process = host.workers["b"].process
    os.kill(process.pid, signal.SIGSTOP)
    for tenths in range(300):  # times that are more than half a second apart are the host's own sleep
        for name in ("a", "c"):
            host.workers[name].heard = host.workers["b"].heard + tenths / 10
        host.supervisor.check(host.workers["b"].heard + tenths / 10)
    assert host.news == [
        f"worker b (process {process.pid}) has been silent for 10 s: "
        "it hangs or was suspended, and the run waits for it"
    ]
    process.kill()
    host.close()


def test_a_worker_that_takes_long_to_start_is_named_once(plan: Plan, tmp_path: Path) -> None:
    host = LocalHost("")
    host.prepare(new_order(plan, RunOptions(tmp_path), restart=True))
    for tenths in range(300):
        host.supervisor.check(host.workers["b"].heard + tenths / 10)
    assert sorted(host.news) == [
        f"worker {name} has been starting for 10 s: a stage takes long to set up, or a process was suspended"
        for name in "abc"
    ]
    host.close()


def test_a_host_whose_agent_is_started_again_counts_on(plan: Plan, tmp_path: Path) -> None:
    order = replace(new_order(plan, RunOptions(tmp_path), restart=True), fired={"c": 70})
    host = LocalHost("")
    host.prepare(order)
    assert frames(host) == {"a": 0, "b": 0, "c": 70}
    host.close()


def test_workers_that_left_for_a_move_come_back_if_it_is_not_ended(host: LocalHost, plan: Plan) -> None:
    new = plan_to_data(plan_after_move(plan, ["b"], "c"))
    host.ask(MoveOrder(leaving=("b", "c")))
    attend(host, lambda: phases(host) == {"a": "running", "b": "absent", "c": "absent"})
    host.supervisor.check(time.monotonic() + 61.0)
    attend(host, lambda: host.status().all("running"))
    assert host.news[0].startswith("worker b, c begins again at its old place: the move was not ended")
    with pytest.raises(FollowspotError, match="the move took too long"):
        host.ask(MoveOrder(plan=new))
    host.ask(MoveOrder(plan=plan_to_data(plan), back=True))
    host.ask(MoveOrder(leaving=("b", "c")))
    attend(host, lambda: phases(host)["c"] == "absent")
    host.ask(MoveOrder(plan=new))
    attend(host, lambda: phases(host) == {"a": "running", "c": "running"})


def test_a_worker_begins_at_its_new_place_when_the_old_one_has_left(host: LocalHost, plan: Plan) -> None:
    """A host that did not answer gets both orders at once."""
    old = {name: worker.process for name, worker in host.workers.items()}
    begun = {}
    spawn = host.pool.spawn

    def noted(name: str, *rest: object, **named: object) -> None:
        begun[name] = old[name].poll()
        spawn(name, *rest, **named)  # type: ignore[arg-type]

    host.pool.spawn = noted  # type: ignore[method-assign]
    host.ask(MoveOrder(leaving=("b", "c")))
    host.ask(MoveOrder(plan=plan_to_data(plan)))
    attend(host, lambda: host.status().all("running") and host.workers["c"].incarnation > 0)
    assert begun.keys() == {"b", "c"}
    assert None not in begun.values(), "one at a time counts in the ledger"
