"""A live worker whose cameras, on the other end of real rings, send what is well-formed and extreme."""

from __future__ import annotations

import socket
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from followspot.graph.compile import compile_graph
from followspot.message_checks.sealing import seal
from followspot.messages import MAX_SEQ, MAX_TIME, Header, stamped
from followspot.plugins.registry import load_stage, use_plugin_files
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Watermark
from followspot.worker.build import build_worker
from followspot.worker.latency import MOST_PATHS, OTHERS
from followspot.worker.ledger import Ledger
from followspot.worker.reporting.stage_status import paths_now, stages_now
from followspot.worker.scheduler import Scheduler
from followspot.worker.wiring import RunOptions, Wiring
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a:    {uses: ticks.live}
  b:    {uses: ticks.live}
  sum:  {uses: ticks.sum, in: {numbers: [a, b]}, deadline: 0.1}
  save: {uses: ticks.write, in: {number: a}}
"""
PLACEMENT = "placement: p\nworkers:\n  far: {stages: [a, b]}\n  main: {stages: [sum, save]}\n"


class Fed:
    """The worker `main` in a thread; `a` and `b` are fed by the test over the rings that lead to it."""

    def __init__(self, folder: Path) -> None:
        (folder / "g.yaml").write_text(GRAPH)
        (folder / "p.yaml").write_text(PLACEMENT)
        use_plugin_files([str(TICKS)])
        plan = compile_graph(
            folder / "g.yaml", placement=folder / "p.yaml", plugin_files=[TICKS], edges="ring"
        )
        self.numbers = {edge.from_stage + edge.to_stage: n for n, edge in enumerate(plan.edges)}
        pairs = {number: socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for number in range(3)}
        self.ledger = Ledger(len(plan.edges))
        edge_factory = WorkerEdgeFactory(
            plan, {}, {number: pair[1] for number, pair in pairs.items()}, None, "run"
        )
        self.scheduler: Scheduler = build_worker(
            Wiring(plan), "main", self.ledger, RunOptions(folder), edge_factory
        )
        self.writers = {number: RingWriter([pair[0]], 8) for number, pair in pairs.items()}
        self.written = folder / "ticks.csv"
        self.problem: BaseException | None = None
        self.scheduler.setup()
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        try:
            self.scheduler.run()
        except BaseException as error:
            self.problem = error

    def send(self, edge: str, header: Header) -> None:
        """One number, as soon as there is credit."""
        writer = self.writers[self.numbers[edge]]
        tick = sys.modules[load_stage("ticks.live").__module__].tick(1)
        until(lambda: writer.credit() > 0 or not self.thread.is_alive())
        writer.send(stamped(seal(tick), header))
        writer.flush()

    def count(self, edge: str) -> int:
        """Messages of an edge that were delivered, late or unmatched."""
        count = self.ledger.count(self.numbers[edge])
        return count.delivered + count.late + count.unmatched

    def end(self) -> None:
        for writer in self.writers.values():
            writer.send(Watermark(END))
        self.thread.join(60)
        assert not self.thread.is_alive()
        self.scheduler.close()
        for writer in self.writers.values():
            writer.close()
        assert self.problem is None, self.problem


@pytest.fixture
def fed(tmp_path: Path) -> Iterator[Fed]:
    made = Fed(tmp_path)
    yield made
    made.end()


def until(condition: object) -> None:
    assert callable(condition)
    limit = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < limit, "it never happened"
        time.sleep(0.005)


@pytest.mark.parametrize("entered", [MAX_TIME, -MAX_TIME])
@pytest.mark.parametrize("captured", [MAX_TIME, -MAX_TIME, 0])
def test_a_join_whose_only_message_claims_to_have_entered_at_any_time_goes_on(
    fed: Fed, entered: int, captured: int
) -> None:
    fed.send("asum", Header("a", MAX_SEQ, captured, entered))
    fed.send("asave", Header("a", 0, 0, 0))
    until(lambda: fed.count("asave") == 1)
    assert stages_now(fed.scheduler, {})
    fed.send("bsum", Header("b", 0, captured, 0))
    until(lambda: fed.count("bsum") == 1 == fed.count("asum"))
    assert fed.thread.is_alive()


def test_names_of_sources_without_end_fill_no_memory(fed: Fed) -> None:
    names = 3 * MOST_PATHS
    for number in range(names):
        fed.send("asave", Header(f"camera{number}", number, number, 0))
    until(lambda: fed.count("asave") == names)
    found = paths_now(fed.scheduler)
    assert len(found) == MOST_PATHS + 1
    assert OTHERS in {path.origin for path in found}
