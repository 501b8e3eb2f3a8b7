"""The report of a run: ledger, latency, each stage's figures, warnings and errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from followspot.control.clock_status import ClockStatus
from followspot.control.worker_report import RUN_AGAIN, WorkerReport
from followspot.graph.frame_count import counted_sources
from followspot.graph.plan import Plan, PlannedEdge
from followspot.operator.reporting.early_ends import early_ends
from followspot.operator.reporting.silence import Silence, silences
from followspot.operator.reporting.unused import unused_messages
from followspot.worker.ledger import COLUMNS, EdgeCount, Ledger


@dataclass(frozen=True)
class RunReport:
    """The report of a whole run. seconds: from the start of all workers to the end of the last."""

    plan: Plan
    seconds: float
    stopped: bool
    """True if the user ended the run early."""
    workers: tuple[WorkerReport, ...]
    edges: tuple[tuple[PlannedEdge, EdgeCount], ...]
    errors: tuple[str, ...] = field(default=())
    news: tuple[str, ...] = ()
    """Faults during the run that were repaired, a line each."""
    clocks: Mapping[str, ClockStatus] = field(default_factory=dict)
    """Offsets of the hosts' clocks from the reference clock, by host."""
    outs: Mapping[str, str] = field(default_factory=dict)
    """Output folders on other hosts, by host."""
    begun: bool = True
    """False if the run ended before its stages were started."""

    @property
    def frames(self) -> int:
        """The largest number of messages that a source of frames sent.

        A worker counts them since it began, an edge through all restarts of its ends.
        """
        own = counted_sources(self.plan)
        sent = (count.produced for edge, count in self.edges if edge.from_stage in own)
        return max((*sent, *(worker.frames for worker in self.workers)), default=0)

    @property
    def warnings(self) -> tuple[str, ...]:
        """The news of the run, the warnings of all workers, sources that ended early, and what joins did not
        use while their sources went on. A run that failed left messages in its queues, of which the errors
        say why, not the joins.
        """
        warnings = (text for worker in self.workers for text in worker.warnings)
        early = early_ends(self.plan, self.workers)
        without = {edge.to_stage for edge, _ in self.edges if edge.from_stage in early}
        joined = [(edge, count) for edge, count in self.edges if edge.to_stage not in without]
        return (
            *self.news,
            *warnings,
            *early.values(),
            *(() if self.errors else unused_messages(self.plan, joined)),
        )

    @cached_property
    def silences(self) -> tuple[Silence, ...]:
        """Ports that never gave a message with rows, although all that feeds their stage did; none of a run
        that did not begin, or that failed before its first message, of which the errors say why.
        """
        tried = self.begun and (not self.errors or any(count.produced for _, count in self.edges))
        return silences(self.plan, self.edges) if tried else ()

    @property
    def unbalanced(self) -> tuple[str, ...]:
        """Edges of a run without errors on which not every message is accounted for exactly once."""
        if self.errors:
            return ()
        return tuple(f"{e.name}: {_imbalance(e, count)}" for e, count in self.edges if not count.balanced)

    @property
    def ok(self) -> bool:
        """True if the run had no error and every message is accounted for."""
        return not self.errors and not self.unbalanced


def _imbalance(edge: PlannedEdge, count: EdgeCount) -> str:
    """What is wrong with a count. Only over Zenoh it may be another program that has sent on the edge."""
    text = f"{count.in_flight} messages are unaccounted for"
    if count.surplus:
        text = f"{count.surplus} messages were accounted for beyond those that were sent"
    if edge.kind != "zenoh":
        return f"{text} (a bug)"
    return f"{text}; if a warning says that it refused something, a stranger sent on it, else it is a bug"


def edge_counts(
    plan: Plan, ledger: Ledger, restarts: Mapping[str, int]
) -> tuple[tuple[PlannedEdge, EdgeCount], ...]:
    """Each edge with its counts; messages in flight at the death of a worker are counted as lost.

    restarts: number of restarts of each worker. Each death loses at most the messages that can be in flight:
    those sent ahead to the slowest reader, as many unread ones of an earlier writer, and those that a live
    source has buffered. Edges that left the graph come last.
    """
    ahead: dict[tuple[str, str], int] = {}
    for edge in plan.edges:
        port = edge.from_stage, edge.from_port
        ahead[port] = max(ahead.get(port, 0), edge.capacity)
    kept = {stage.name: stage.depth for stage in plan.stages}
    counted = []
    for number, edge in plan.numbered():
        ends = {plan.worker_of(edge.from_stage), plan.worker_of(edge.to_stage)}
        deaths = sum(restarts.get(worker, 0) for worker in ends)
        under_way = 2 * ahead[edge.from_stage, edge.from_port] + kept[edge.from_stage] + 1
        counted.append((edge, ledger.count(number).with_lost(deaths * under_way)))
    return (*counted, *(_left(edge, ledger.count(number)) for number, edge in plan.former))


def _left(edge: PlannedEdge, count: EdgeCount) -> tuple[PlannedEdge, EdgeCount]:
    """An edge that left the graph, with its messages in flight counted as lost."""
    return edge, count.with_lost(count.in_flight)


def summed_ledger(counts: Sequence[Sequence[int]], edges: int) -> Ledger:
    """The ledger of a run: the sum of the ledgers of its hosts, given as rows of columns.

    A ledger of another length is left out; `RunView` says so.
    """
    words = np.zeros(edges * COLUMNS, np.int64)
    for found in counts:
        if len(found) == len(words):
            words += np.array(found, np.int64)
    return Ledger(edges, memoryview(words.tobytes()).cast("q"))


def _unread_error(edge: PlannedEdge, count: EdgeCount) -> str:
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
    """The report of a run from the reports of all its workers."""
    errors = tuple(worker.error for worker in workers if worker.error)
    edges = edge_counts(plan, ledger, restarts or {})
    if not (errors or plan.live or any((restarts or {}).values())):
        errors = tuple(_unread_error(edge, count) for edge, count in edges if count.away)
    return RunReport(
        plan=plan,
        seconds=seconds,
        stopped=stopped,
        workers=tuple(workers),
        edges=edges,
        errors=errors,
        news=tuple(news),
        clocks=clocks or {},
        outs=outs or {},
    )
