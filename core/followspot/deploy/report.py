"""What a run reports: ledger, latency, what each stage did, warnings, and what went wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from followspot.deploy.clocks.status import ClockStatus
from followspot.graph.plan import Plan, PlannedEdge
from followspot.ranges import Count, Figure
from followspot.runtime.latency import PathLatency
from followspot.runtime.ledger import COLUMNS, EdgeCount, Ledger
from followspot.runtime.source import LIVE_DEPTH
from followspot.runtime.worker import Worker

MAX_WARNINGS = 200
"""Different warnings kept per worker; further ones are only counted."""
_REPEAT = "the results are not whole, so run the replay again"


@dataclass(frozen=True)
class StageReport:
    """What one stage did in a run."""

    stage: str
    fired: Count
    skipped: Count
    restarts: Count
    busy_ms: Figure


@dataclass(frozen=True)
class WorkerReport:
    """What one worker did; error is empty where it ended cleanly.

    absent: whether it was not there at the end of the run.
    """

    worker: str
    frames: Count
    stages: tuple[StageReport, ...] = ()
    paths: tuple[PathLatency, ...] = ()
    warnings: tuple[str, ...] = ()
    error: str = ""
    absent: bool = False

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return asdict(self)


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


class Warnings:
    """Collects what stages warn of; the same text is kept once.

    tell: gets the stage and text of each.
    """

    def __init__(self, tell: Callable[[str, str], None] = lambda stage, text: None) -> None:
        self._tell = tell
        self._counts: dict[str, int] = {}
        self._more = 0
        self.last: dict[str, str] = {}
        """The newest of each stage."""

    def add(self, stage: str, text: str) -> None:
        """A stage's warning; safe from any thread."""
        self.last[stage] = text
        self._tell(stage, text)
        line = f"{stage}: {text}"
        if line in self._counts or len(self._counts) < MAX_WARNINGS:
            self._counts[line] = self._counts.get(line, 0) + 1
        else:
            self._more += 1

    def lines(self) -> tuple[str, ...]:
        """The texts, with how often each was said."""
        lines = [text + (f" ({count} times)" if count > 1 else "") for text, count in self._counts.items()]
        return (*lines, f"{self._more} more warnings") if self._more else tuple(lines)


def worker_report(name: str, worker: Worker, warnings: Warnings, error: str = "") -> WorkerReport:
    """The report of a worker that has ended, one way or the other."""
    for inlet in worker.readers:
        if inlet.invalid_reason:
            warnings.add(inlet.name, f"invalid message: {inlet.invalid_reason}")
    return WorkerReport(
        name,
        max((source.yielded for source in worker.sources), default=0),
        tuple(
            StageReport(c.name, c.count.fired, c.count.skipped, c.count.restarts, c.count.busy_ns / 1e6)
            for c in worker.cells
        ),
        tuple(path.summary(origin, c.name) for c in worker.cells for origin, path in c.paths.items()),
        warnings.lines(),
        error,
    )


def missing(worker: Worker) -> str:
    """The error that it is in a replay if messages were lost on their way to the worker; "" for none."""
    lost = [f"{inlet.name}: {inlet.missing} messages" for inlet in worker.readers if inlet.missing]
    return f"{', '.join(lost)} were lost on their way; {_REPEAT}" if lost else ""


def edge_counts(
    plan: Plan, ledger: Ledger, restarts: Mapping[str, int]
) -> tuple[tuple[PlannedEdge, EdgeCount], ...]:
    """Each edge with its counts; restarts: of each worker, for messages are lost with a worker that dies.

    At most as many are lost with one as may be under way: those that the writer sent ahead to its slowest
    reader, as many from a writer before that are not read yet, and what a live source has made.
    """
    home = {stage.name: stage.worker for stage in plan.stages}
    ahead: dict[tuple[str, str], int] = {}
    for edge in plan.edges:
        port = edge.from_stage, edge.from_port
        ahead[port] = max(ahead.get(port, 0), edge.room)
    counted = []
    for number, edge in enumerate(plan.edges):
        deaths = sum(restarts.get(worker, 0) for worker in {home[edge.from_stage], home[edge.to_stage]})
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
    return f"{edge.name}: {count.away} messages came when their reader was away; {_REPEAT}"


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
