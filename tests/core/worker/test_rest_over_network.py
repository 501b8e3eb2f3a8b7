"""A worker that is to change is not at rest while what it has sent over the network is on its way."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from tests.core.worker.pair import PAIR, TICKS, with_another_edge
from tests.integration.running import wait_until

from followspot.control.swap import ChangeOrder, ChangeStatus, Step
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.messages import Message
from followspot.plugins.registry import use_plugin_files
from followspot.transport.edge import PortReader
from followspot.transport.zenoh.edge import open_session
from followspot.worker.build import build_worker
from followspot.worker.change.hot_swap import HotSwap
from followspot.worker.change.rewiring import Rewiring
from followspot.worker.ledger import Ledger
from followspot.worker.wiring import RunOptions, Wiring
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

ENDLESS = PAIR.replace("{uses: ticks.count}", "{uses: ticks.count, with: {count: 1000000}}")
SOON = 0.3
"""Seconds in which nothing must happen."""


class Changing:
    """A source in a worker of its own, and the readers of its edge before and after a change."""

    def __init__(
        self, folder: Path, edge_factory: WorkerEdgeFactory, former: PortReader, later: PortReader
    ) -> None:
        wiring, ledger, options = Wiring(edge_factory.plan), Ledger(2), RunOptions(folder)
        self.former, self.later = former, later
        self.new = with_another_edge(edge_factory.plan)
        self.scheduler = build_worker(wiring, "a", ledger, options, edge_factory)
        self.answers: list[ChangeStatus] = []
        self.swap = HotSwap(
            self.scheduler,
            self.answers.append,
            lambda plan: Rewiring(
                self.scheduler, Wiring(self.new), "a", ledger, options, edge_factory.for_plan(self.new)
            ),
        )
        self.turn = 0

    def tell(self, step: Step, until: int = -1) -> None:
        self.turn += 1
        plan = plan_to_data(self.new) if step == "build" else None
        order = ChangeOrder(id="1", step=step, stages=(), turn=self.turn, until=until, plan=plan)
        self.scheduler.between_firings(partial(self.swap.carry_out, order))

    def answered(self, phase: str, seconds: float = 60.0) -> bool:
        """Whether the worker says so of the step that it was told last."""
        return wait_until(
            lambda: any((said.turn, said.phase) == (self.turn, phase) for said in self.answers), seconds
        )


@contextmanager
def changing(folder: Path) -> Iterator[Changing]:
    (folder / "g.yaml").write_text(ENDLESS)
    use_plugin_files([str(TICKS)])
    plan = compile_graph(folder / "g.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    with open_session() as session:
        theirs = WorkerEdgeFactory(plan, {}, {}, session, "run")
        former = theirs.reader(0, Message)
        later = theirs.for_plan(with_another_edge(plan)).reader(1, Message)
        edge_factory = WorkerEdgeFactory(plan, {}, {}, session, "run")
        run = Changing(folder, edge_factory, former, later)
        assert wait_until(lambda: edge_factory.zenoh.announce_again() or former.matched())
        edge_factory.wait_matched()
        run.scheduler.setup()
        thread = threading.Thread(target=run.scheduler.run)
        thread.start()
        try:
            yield run
        finally:
            former.close()
            later.close()
            run.scheduler.stop()
            thread.join()


def test_a_worker_rests_once_all_that_it_sent_is_said_to_be_taken(tmp_path: Path) -> None:
    with changing(tmp_path) as run:
        run.tell("build")
        assert not run.answered("built", SOON), "the new edge has not found its other end"
        assert wait_until(run.later.matched)
        assert run.answered("built")
        assert wait_until(lambda: run.scheduler.sources.all[0].yielded > 0)
        run.tell("hold")
        assert run.answered("held")
        run.tell("rest", run.answers[-1].rested.time)
        assert not run.answered("resting", SOON), "nobody has taken what it sent"
        run.former.report_at_once(True)
        run.former.poll()
        assert run.answered("resting")
