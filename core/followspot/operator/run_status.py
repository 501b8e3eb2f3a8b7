"""A run at one moment, for those who look on: the operator's page, `followspot top`, metrics."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from followspot.control.clock_status import ClockStatus
from followspot.control.host import WorkerStatus
from followspot.graph.plan import Plan, PlannedEdge
from followspot.ranges import Age, Count
from followspot.worker.ledger import COLUMNS, EdgeCount, tally

OLD = 1.0
"""Age, s, from which on a status is shown as old; workers speak and hosts are asked five times a second."""


@dataclass(frozen=True)
class SeenHost:
    """One of the other hosts. age_s: None where it was never heard; absent: whether it does not answer."""

    name: str
    age_s: Age | None
    absent: bool


@dataclass(frozen=True)
class RunStatus:
    """One moment.

    workers: all of the plan, with their ages; counts: words of the ledger, of all edges of the plan; fired,
    expected: frames done and to be done; clocks: of the hosts that go by that of another one, "" for the
    operator's own.
    """

    workers: tuple[WorkerStatus, ...]
    counts: tuple[Count, ...]
    fired: Count
    expected: Count | None
    news: tuple[str, ...] = ()
    clocks: Mapping[str, ClockStatus] = field(default_factory=dict)
    hosts: tuple[SeenHost, ...] = ()

    def later(self, seconds: float) -> RunStatus:
        """The same status when it has become older by so many seconds, s."""
        workers = (w if w.age_s is None else replace(w, age_s=w.age_s + seconds) for w in self.workers)
        hosts = (h if h.age_s is None else replace(h, age_s=h.age_s + seconds) for h in self.hosts)
        return replace(self, workers=tuple(workers), hosts=tuple(hosts))

    def faults(self) -> tuple[str, ...]:
        """What is absent or was not heard lately, a line each; workers of such a host are not named again."""
        return faults(self.hosts, self.workers)

    def edges(self, plan: Plan) -> Iterator[tuple[PlannedEdge, EdgeCount]]:
        """Each edge with its counts."""
        for number, edge in enumerate(plan.edges):
            row = self.counts[number * COLUMNS : (number + 1) * COLUMNS]
            if row:  # a host that has not answered yet has none
                yield edge, tally(row)


def faults(hosts: Iterable[SeenHost], workers: Iterable[WorkerStatus]) -> tuple[str, ...]:
    """See `RunStatus.faults`."""
    found = {host.name: line for host in hosts if (line := _host_fault(host))}
    others = (_worker_fault(worker) for worker in workers if worker.host not in found)
    return (*found.values(), *(line for line in others if line))


def is_old(worker: WorkerStatus) -> bool:
    """Whether a worker that should be heard was not heard lately."""
    return worker.phase == "running" and worker.age_s is not None and worker.age_s > OLD


def is_unheard(worker: WorkerStatus) -> bool:
    """Whether only what a worker said some time ago is known of it."""
    return worker.phase == "absent" or is_old(worker)


def _host_fault(host: SeenHost) -> str:
    """What is wrong with a host, "" for nothing."""
    if host.age_s is None:
        return f"host {host.name} is absent: nothing is heard of the run there"
    if host.absent:
        return f"host {host.name} is absent: last heard {host.age_s:.0f} s ago"
    return f"host {host.name} was last heard {host.age_s:.1f} s ago" if host.age_s > OLD else ""


def _worker_fault(worker: WorkerStatus) -> str:
    """What is wrong with a worker, "" for nothing."""
    if worker.phase == "absent":
        when = "never heard" if worker.age_s is None else f"last heard {worker.age_s:.0f} s ago"
        return f"worker {worker.name} is absent: {when}"
    if worker.phase in ("starting", "ready") and worker.restarts:
        return f"worker {worker.name} is starting again"
    return f"worker {worker.name} was last heard {worker.age_s:.1f} s ago" if is_old(worker) else ""
