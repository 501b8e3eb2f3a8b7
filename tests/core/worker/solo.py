"""One worker in the calling thread, without a host: what the runtime does by itself."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from followspot.control.tapping import Tapping
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.operator.reporting.report import RunReport, merge
from followspot.transport.ring.link import socket_pair
from followspot.worker.build import build_worker
from followspot.worker.ledger import Ledger
from followspot.worker.reporting.report import Warnings, worker_report
from followspot.worker.taps.port_taps import tap, taps_of
from followspot.worker.wiring import RunOptions, Wiring
from followspot.worker.worker_edge_factory import WorkerEdgeFactory


class Solo:
    """A plan of one worker, built and not yet run. Raises StageError if a stage cannot be built."""

    def __init__(self, plan: Plan, out: Path, frames: int | None = None) -> None:
        self.plan = plan
        self.warnings = Warnings()
        self.ledger = Ledger(len(plan.edges))
        pairs = {number: socket_pair() for number in plan.ring_edges()}
        sending = {number: pair[0] for number, pair in pairs.items()}
        receiving = {number: pair[1] for number, pair in pairs.items()}
        edge_factory = WorkerEdgeFactory(plan, sending, receiving, None, "solo")
        options = RunOptions(out, frames, self.warnings.add)
        self.scheduler = build_worker(Wiring(plan), plan.workers[0].name, self.ledger, options, edge_factory)

    def tap(self, tappings: Iterable[Tapping]) -> None:
        """Look at ports from the first message on."""
        tap(self.scheduler, tappings)

    def run(self) -> RunReport:
        """Run to the end of all streams; what a stage raises stands in the report."""
        error = ""
        try:
            self.scheduler.setup()
            self.scheduler.run()
        except FollowspotError as failure:
            error = str(failure)
        finally:
            for found in tuple(taps_of(self.scheduler)):
                found.detach()
                found.close()
            self.scheduler.close()
        report = worker_report(self.plan.workers[0].name, self.scheduler, self.warnings, error)
        return merge(self.plan, self.ledger, [report], 0.0, stopped=False)
