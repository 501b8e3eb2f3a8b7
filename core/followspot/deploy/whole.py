"""The newest pictures of all hosts of a run, as one: how far it is, its status, and its report at the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from followspot.deploy.clocks.status import ClockStatus
from followspot.deploy.host import HostStatus, WorkerStatus
from followspot.deploy.report import RunReport, WorkerReport, merge, summed
from followspot.deploy.status import RunStatus
from followspot.graph.plan import Plan
from followspot.runtime.ledger import Ledger
from followspot.runtime.worker import Progress


@dataclass(frozen=True)
class Whole:
    """hosts: their pictures, by name, "" for the operator's own; news: that no host knows of."""

    plan: Plan
    hosts: Mapping[str, HostStatus]
    news: Sequence[str] = ()

    def workers(self) -> Iterator[WorkerStatus]:
        """Of all hosts."""
        return (worker for status in self.hosts.values() for worker in status.workers)

    def progress(self) -> Progress:
        """Of the sink that is furthest behind; of the sources where no stage is a sink."""
        senders = {edge.from_stage for edge in self.plan.edges}
        sinks = {stage.worker for stage in self.plan.stages if stage.name not in senders}
        fired = [worker.fired for worker in self.workers() if worker.name in sinks]
        return Progress(min(fired, default=0), max((worker.time for worker in self.workers()), default=-1))

    def expected(self) -> int | None:
        """Frames that will be done, where a source knows."""
        return max((w.expected for w in self.workers() if w.expected is not None), default=None)

    def status(self) -> RunStatus:
        """For those who look on."""
        return RunStatus(
            tuple(self.workers()),
            tuple(self._ledger().words.tolist()),
            self.progress().fired,
            self.expected(),
            self._news(),
            self._clocks(),
        )

    def report(self, seconds: float, silent: Mapping[str, str], *, stopped: bool) -> RunReport:
        """At the end, workers in the order of the plan. silent: hosts that do not answer, and why."""
        found = {worker.name: worker for worker in self.workers()}
        reports = [
            _report(found.get(w.name), silent.get(w.host, f"worker {w.name} did not end in time"), w.name)
            for w in self.plan.workers
        ]
        return merge(
            self.plan,
            self._ledger(),
            reports,
            seconds,
            stopped=stopped,
            restarts={name: worker.restarts for name, worker in found.items()},
            news=self._news(),
            clocks=self._clocks(),
            outs={name: status.out for name, status in self.hosts.items() if name},
        )

    def _ledger(self) -> Ledger:
        return summed([status.counts for status in self.hosts.values()], len(self.plan.edges))

    def _news(self) -> tuple[str, ...]:
        told = [(name, line) for name, status in self.hosts.items() for line in status.news]
        return (*self.news, *(f"{name}: {line}" if name else line for name, line in told))

    def _clocks(self) -> dict[str, ClockStatus]:
        """Of the hosts that go by the clock of another one."""
        return {name: status.clock for name, status in self.hosts.items() if status.clock.reference}


def _report(found: WorkerStatus | None, why: str, name: str) -> WorkerReport:
    """A worker's own, or why there is none."""
    return WorkerReport(name, 0, error=why) if found is None or found.report is None else found.report
