"""The status of a run at one moment, as the page, `followspot top` and the metrics show it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from followspot.control.clock_status import ClockStatus
from followspot.control.host import WorkerStatus
from followspot.graph.plan import Plan, PlannedEdge
from followspot.operator.stalls import stalled_edges
from followspot.valid_values.numbers import Age, Count
from followspot.worker.ledger import COLUMNS, EdgeCount, tally

OLD = 1.0
"""Age, s, above which a status counts as old; workers report and hosts are polled five times a second."""


@dataclass(frozen=True)
class SeenHost:
    """A remote host as the operator sees it."""

    name: str
    age_s: Age | None
    """Age of its last answer, s; None if it never answered."""
    absent: bool
    """Whether it does not answer now."""


@dataclass(frozen=True)
class RunStatus:
    """The status of a run at one moment."""

    workers: tuple[WorkerStatus, ...]
    """All workers of the plan, with their ages."""
    counts: tuple[Count, ...]
    """The ledger's columns of all edges of the plan, one edge after the other; see `edges`."""
    fired: Count
    """Frames done."""
    expected: Count | None
    """Frames to be done, None if no source knows."""
    news: tuple[str, ...] = ()
    """Events of the run, a line each."""
    clocks: Mapping[str, ClockStatus] = field(default_factory=dict)
    """Clocks of the hosts that follow a reference clock, by host, "" for the operator's own."""
    hosts: tuple[SeenHost, ...] = ()
    """The remote hosts."""
    late: tuple[str, ...] = ()
    """A line for each path that misses its budget."""
    change_awaits: str = ""
    """Reason for which the change under way waits, "" if it does not wait."""
    unfinished_change: str = ""
    """Remains of an interrupted change on hosts, and the remedy; "" if there are none."""

    def later(self, seconds: float) -> RunStatus:
        """The status as it is `seconds` later."""
        workers = (w.later(seconds) for w in self.workers)
        hosts = (h if h.age_s is None else replace(h, age_s=h.age_s + seconds) for h in self.hosts)
        return replace(self, workers=tuple(workers), hosts=tuple(hosts))

    def faults(self) -> tuple[str, ...]:
        """A line for each fault: absent or old hosts and workers, stalled edges, missed budgets.

        If an interrupted change has left something, the first line says so. Workers of a faulty host have no
        line of their own.
        """
        return (*filter(None, [self.unfinished_change]), *faults(self.hosts, self.workers), *self.late)

    def edges(self, plan: Plan) -> Iterator[tuple[PlannedEdge, EdgeCount]]:
        """Each edge with its counts."""
        for number, edge in plan.numbered():
            row = self.counts[number * COLUMNS : (number + 1) * COLUMNS]
            if row:  # a status may have no counts yet
                yield edge, tally(row)


def faults(hosts: Iterable[SeenHost], workers: Iterable[WorkerStatus]) -> tuple[str, ...]:
    """A line for each host or worker that is absent or old, and each edge that stalls: see `RunStatus`."""
    workers = tuple(workers)
    found = {host.name: line for host in hosts if (line := _host_fault(host))}
    others = (_worker_fault(worker) for worker in workers if worker.host not in found)
    return (*found.values(), *(line for line in others if line), *stalled_edges(workers))


def is_old(worker: WorkerStatus) -> bool:
    """True if a running worker's last report is older than `OLD`."""
    return worker.phase == "running" and worker.age_s is not None and worker.age_s > OLD


def is_stale(worker: WorkerStatus) -> bool:
    """True if a worker is absent or its last report is old: its figures are not current."""
    return worker.phase == "absent" or is_old(worker)


def _host_fault(host: SeenHost) -> str:
    """The fault of a host as a line, "" if there is none."""
    if host.age_s is None:
        return f"host {host.name} is absent: nothing is heard of the run there"
    if host.absent:
        return f"host {host.name} is absent: last heard {host.age_s:.0f} s ago"
    return f"host {host.name} was last heard {host.age_s:.1f} s ago" if host.age_s > OLD else ""


def _worker_fault(worker: WorkerStatus) -> str:
    """The fault of a worker as a line, "" if there is none."""
    if worker.phase == "absent":
        when = "never heard" if worker.age_s is None else f"last heard {worker.age_s:.0f} s ago"
        return f"worker {worker.name} is absent: {when}"
    if worker.phase in ("starting", "ready") and worker.restarts:
        return f"worker {worker.name} is starting again"
    return f"worker {worker.name} was last heard {worker.age_s:.1f} s ago" if is_old(worker) else ""
