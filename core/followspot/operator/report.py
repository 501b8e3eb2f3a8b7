"""What a run reports: ledger, latency, what each stage did, warnings, and what went wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from followspot.control.clock_status import ClockStatus
from followspot.control.worker_report import RUN_AGAIN, WorkerReport
from followspot.graph.plan import Plan, PlannedEdge
from followspot.worker.ledger import COLUMNS, EdgeCount, Ledger
from followspot.worker.source import LIVE_DEPTH


@dataclass(frozen=True)
class RunReport:
    """What the whole run did. seconds: from the start of all workers to the end of the last."""

    plan: Plan
    seconds: float
    stopped: bool
    """Whether the user ended it early."""
    workers: tuple[WorkerReport, ...]
    edges: tuple[tuple[PlannedEdge, EdgeCount], ...]
    errors: tuple[str, ...] = field(default=())
    news: tuple[str, ...] = ()
    """What broke during the run and was mended."""
    clocks: Mapping[str, ClockStatus] = field(default_factory=dict)
    """How the clocks of the hosts differ from the one that all go by."""
    outs: Mapping[str, str] = field(default_factory=dict)
    """Where the outputs are that were written on other hosts, by host."""

    @property
    def frames(self) -> int:
        """Messages that the busiest source sent."""
        return max((worker.frames for worker in self.workers), default=0)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Of all workers, and what broke and was mended."""
        return (*self.news, *(text for worker in self.workers for text in worker.warnings))

    @property
    def unbalanced(self) -> tuple[str, ...]:
        """Edges whose messages are not all accounted for, once, though the run ended cleanly: a bug."""
        if self.errors:
            return ()
        return tuple(f"{e.name}: {_imbalance(count)}" for e, count in self.edges if not count.balanced)

    @property
    def ok(self) -> bool:
        """Whether the run did what it was asked, and every message is accounted for."""
        return not self.errors and not self.unbalanced


def _imbalance(count: EdgeCount) -> str:
    if count.surplus:
        return f"{count.surplus} messages were accounted for beyond those that were sent"
    return f"nobody knows what became of {count.in_flight} messages"


def edge_counts(
    plan: Plan, ledger: Ledger, restarts: Mapping[str, int]
) -> tuple[tuple[PlannedEdge, EdgeCount], ...]:
    """Each edge with its counts; restarts: of each worker, for messages are lost with a worker that dies.

    At most as many are lost with one as may be under way: those that the writer sent ahead to its slowest
    reader, as many from a writer before that are not read yet, and what a live source has made.
    """
    ahead: dict[tuple[str, str], int] = {}
    for edge in plan.edges:
        port = edge.from_stage, edge.from_port
        ahead[port] = max(ahead.get(port, 0), edge.capacity)
    counted = []
    for number, edge in enumerate(plan.edges):
        ends = {plan.worker_of(edge.from_stage), plan.worker_of(edge.to_stage)}
        deaths = sum(restarts.get(worker, 0) for worker in ends)
        under_way = 2 * ahead[edge.from_stage, edge.from_port] + LIVE_DEPTH + 1
        counted.append((edge, ledger.count(number).with_lost(deaths * under_way)))
    return tuple(counted)


def summed(counts: Sequence[Sequence[int]], edges: int) -> Ledger:
    """The ledger of a run from those of its hosts: each counts what happens to a message there."""
    words = np.zeros(edges * COLUMNS, np.int64)
    for found in counts:
        if len(found) == len(words):
            words += np.array(found, np.int64)
    return Ledger(edges, memoryview(words.tobytes()).cast("q"))


def _unread(edge: PlannedEdge, count: EdgeCount) -> str:
    return f"{edge.name}: {count.away} messages came when their reader was away; {RUN_AGAIN}"


def merge(
    plan: Plan,
    ledger: Ledger,
    workers: Sequence[WorkerReport],
    seconds: float,
    *,
    stopped: bool,
    restarts: Mapping[str, int] | None = None,
    news: Sequence[str] = (),
    outs: Mapping[str, str] | None = None,
    clocks: Mapping[str, ClockStatus] | None = None,
) -> RunReport:
    """One report from those of all workers."""
    errors = tuple(worker.error for worker in workers if worker.error)
    edges = edge_counts(plan, ledger, restarts or {})
    if not (errors or plan.live or any((restarts or {}).values())):
        errors = tuple(_unread(edge, count) for edge, count in edges if count.away)
    return RunReport(
        plan, seconds, stopped, tuple(workers), edges, errors, tuple(news), clocks or {}, outs or {}
    )
