"""One stage in its worker: when it passes on what it knows, and what it notes of time."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.worker.solo import Solo

from followspot.graph.compile import compile_graph
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.transport.ring.reader import RingReader
from followspot.transport.token import ABSENT
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import Ledger
from followspot.worker.runners.error_policy import recover
from followspot.worker.wiring import Wiring

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
CHAIN = """
a: {uses: ticks.SOURCE, with: {count: 20}}
b: {uses: ticks.accumulate, in: {number: a, before: {from: b, delay: 1}}}
save: {uses: ticks.write, in: {number: b}}
"""
S = 1_000_000_000


def solo(folder: Path, source: str = "count", edges: str = "auto") -> Solo:
    path = folder / "graph.yaml"
    lines = CHAIN.replace("SOURCE", source).strip().splitlines()
    path.write_text("graph: g\nstages:\n" + "".join(f"  {line}\n" for line in lines))
    return Solo(compile_graph(path, plugin_files=[TICKS], edges=edges), folder)  # type: ignore[arg-type]


def test_what_is_known_with_a_message_is_passed_on_with_the_message(tmp_path: Path) -> None:
    """A watermark that came before the stage fired needs no second look at the stage."""
    run = solo(tmp_path)
    run.scheduler.setup()
    runners = {runner.name: runner for runner in run.scheduler.runners}
    tick = next(iter(runners["a"].stage.process()))
    (into,), (onward,) = runners["b"].join.members, runners["save"].join.members
    into.put(seal(stamped(tick, Header("a", 0, 900))))
    into.advance(1000)
    runners["b"].step()
    assert (runners["b"].count.fired, len(onward.messages), onward.watermark) == (1, 1, 1000)


def test_a_stage_is_looked_at_whenever_more_is_settled_and_not_else() -> None:
    queue = InputQueue("edge", (ledger := Ledger(1)).words, ledger.row(0), depth=1, lateness=0)
    looks: list[int] = []
    queue.wake = lambda: looks.append(queue.watermark)
    for watermark in (5, 5, 3, 8, ABSENT, 9):
        queue.advance(watermark)
    assert looks == [5, 8, ABSENT, 9], "who was away may come back with less"


@pytest.mark.parametrize(("source", "live"), [("count", False), ("live", True)])
def test_a_delay_is_by_capture_time_and_the_newest_only_in_a_replay(
    tmp_path: Path, source: str, live: bool
) -> None:
    wiring = Wiring(solo(tmp_path, source).plan)
    delayed = next(edge for edge in wiring.plan.edges if edge.delay)
    plain = next(edge for edge in wiring.plan.edges if not edge.delay)
    assert wiring.live is live
    assert wiring.timed(delayed)
    assert wiring.timed(plain) is not live


@pytest.mark.parametrize("source", ["count", "live"])
def test_latency_is_by_the_clock_of_all(tmp_path: Path, source: str) -> None:
    run = solo(tmp_path, source)
    for runner in run.scheduler.runners:
        runner.clock.steady = 1000 * S
    report = run.run()
    assert report.ok
    (path,) = [path for worker in report.workers for path in worker.paths]
    assert path.worst_ms < 100_000


def test_a_worker_that_has_ended_leaves_no_edge_open(tmp_path: Path) -> None:
    run = solo(tmp_path, edges="ring")
    readers = [queue.reader for queue in run.scheduler.ends.readers if queue.reader is not None]
    assert len(readers) == 3
    assert all(reader.fileno() >= 0 for reader in readers)
    assert run.run().ok
    assert [reader.fileno() for reader in readers] == [-1, -1, -1]


def test_the_latency_of_64_sources_is_measured_apart_and_that_of_all_others_together(tmp_path: Path) -> None:
    save = next(runner for runner in solo(tmp_path).scheduler.runners if runner.name == "save")
    for number in range(70):
        save.deliver(None, Header(f"camera{number}/cam", 0, 0))
    assert list(save.paths) == [*(f"camera{number}/cam" for number in range(64)), "others"]
    assert save.paths["others"].count == 6


def test_a_stage_that_is_rebuilt_after_an_error_knows_that_it_worked_before(tmp_path: Path) -> None:
    run = solo(tmp_path)
    run.scheduler.setup()
    runner = next(runner for runner in run.scheduler.runners if runner.name == "b")
    runner.on_error, first = "restart", runner.stage
    recover(runner, Header("a", 0, 900), ValueError("no"))
    assert (first.context.resumed, runner.stage.context.resumed) == (False, True)
    assert runner.stage is not first
    run.scheduler.close()


def test_edges_from_a_port_to_one_worker_share_datagrams(tmp_path: Path) -> None:
    """`b` feeds back to itself and feeds `save`."""
    run = solo(tmp_path, edges="ring")
    readers = {queue.name: queue.reader for queue in run.scheduler.ends.readers}
    assert run.run().ok
    counts = sorted(
        reader._received
        for name, reader in readers.items()
        if name.startswith("b") and isinstance(reader, RingReader)
    )
    assert [count > 20 for count in counts] == [False, True], counts
    counted = [run.ledger.count(number) for number in range(len(run.plan.edges))]
    assert [(count.sent, count.in_flight, count.lost) for count in counted] == [(20, 0, 0)] * 3
