"""Stages that take the place of others between two firings, in a run of this process."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.host.local_host import LocalHost
from followspot.host.worker_thread import WorkerThread
from followspot.operator.change.hot_swap import change_stages
from followspot.operator.coordinator import Coordinator
from followspot.operator.launch import local_run
from followspot.operator.run_requests import ChangeStages
from followspot.plugins.registry import load_stage
from followspot.worker.scheduler import Scheduler
from followspot.worker.wiring import RunOptions

ALIKE = Path(__file__).parents[2] / "stages" / "alike.py"
PAIR = """
a: {uses: alike.count, with: {count: 200}}
b: {uses: alike.count, with: {count: 200}}
x: {uses: alike.double, in: {note: a}}
y: {uses: alike.double, in: {note: b}}
h: {uses: alike.gate, in: {note: x}, with: {at: 50}}
p: {uses: alike.collect, in: {note: h}}
q: {uses: alike.collect, in: {note: y}}
"""


def scheduler_of(run: Coordinator) -> Scheduler:
    """The scheduler of a run in this process, while it is there."""
    (host,) = run.hosts
    assert isinstance(host, LocalHost)
    process = host.workers["main"].process
    assert isinstance(process, WorkerThread)
    assert process.main.worker is not None
    return process.main.worker.scheduler


def change(run: Coordinator, *words: str) -> None:
    change_stages(run, ChangeStages(words=words))


def changed_at_the_gate(
    folder: Path, meddle: Callable[[Coordinator], object]
) -> tuple[Coordinator, ModuleType]:
    """A whole run, changed from another thread while its notes pass slowly from the 50th on."""
    path = folder / "graph.yaml"
    path.write_text("graph: g\nstages:\n" + "".join(f"  {line}\n" for line in PAIR.strip().splitlines()))
    run = local_run(compile_graph(path, plugin_files=[ALIKE]), RunOptions(folder))
    module = sys.modules[load_stage("alike.double").__module__]
    module.Double.sizes.clear()
    module.Collect.got.clear()
    module.Gate.reached, module.Gate.open = threading.Event(), threading.Event()
    problems: list[BaseException] = []

    def meddle_at_the_gate() -> None:
        assert module.Gate.reached.wait(60)
        try:
            meddle(run)
        except BaseException as error:
            problems.append(error)
        module.Gate.open.set()

    meddler = threading.Thread(target=meddle_at_the_gate)
    meddler.start()
    report = run.execute()
    meddler.join()
    assert report.ok, report.errors
    assert not problems, problems
    return run, module


def test_stages_that_are_no_longer_alike_work_alone_and_nothing_is_lost(tmp_path: Path) -> None:
    run, module = changed_at_the_gate(tmp_path, lambda run: change(run, "y.at=7"))
    assert sorted(module.Collect.got) == sorted([(name, n, 2 * n) for name in "pq" for n in range(200)])
    assert 50 <= len(module.Double.sizes) < 200, "together before, each alone after"
    assert run.plan.notes == ("while it ran: y: at = 7",)


def test_a_change_that_fails_leaves_every_stage_as_it_was(tmp_path: Path) -> None:
    def refused(run: Coordinator) -> None:
        before = [runner.stage for runner in scheduler_of(run).runners]
        with pytest.raises(FollowspotError, match="cannot be built: ValueError: no tripling"):
            change(run, "x.at=7", "y=alike.triple")
        assert [runner.stage for runner in scheduler_of(run).runners] == before

    run, module = changed_at_the_gate(tmp_path, refused)
    assert sorted(module.Collect.got) == sorted([(name, n, 2 * n) for name in "pq" for n in range(200)])
    assert len(module.Double.sizes) >= 199
    assert run.plan.notes == ()


def test_a_stage_that_takes_over_knows_that_another_one_worked_in_this_run(tmp_path: Path) -> None:
    resumed: dict[str, bool] = {}

    def changed(run: Coordinator) -> None:
        change(run, "y.at=7")
        resumed.update({runner.name: runner.stage.context.resumed for runner in scheduler_of(run).runners})

    changed_at_the_gate(tmp_path, changed)
    assert {name for name, found in resumed.items() if found} == {"y"}


def test_a_run_that_is_over_is_not_changed(tmp_path: Path) -> None:
    run, _ = changed_at_the_gate(tmp_path, lambda run: None)
    with pytest.raises(FollowspotError, match="the run has ended"):
        change(run, "y.at=7")
