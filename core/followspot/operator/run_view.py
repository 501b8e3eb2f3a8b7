"""The newest pictures of all hosts of a run, as one: how far it is, its status, and its report at the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from followspot.control.clock_status import ClockStatus
from followspot.control.host import HostStatus, WorkerStatus
from followspot.control.worker_report import WorkerReport
from followspot.graph.plan import Plan
from followspot.host.heartbeat import SILENCE
from followspot.operator.report import RunReport, merge, summed
from followspot.operator.run_status import RunStatus, SeenHost, faults
from followspot.worker.ledger import Ledger
from followspot.worker.scheduler import Progress


@dataclass(frozen=True)
class RunView:
    """hosts: their pictures, by name, "" for the operator's own; news: that no host knows of.

    begun: whether all hosts had been heard once: one that was never heard here is not in reach.
    """

    plan: Plan
    hosts: Mapping[str, HostStatus]
    news: Sequence[str] = ()
    begun: bool = False

    def workers(self) -> Iterator[WorkerStatus]:
        """Of all hosts."""
        return (worker for status in self.hosts.values() for worker in status.workers)

    def progress(self) -> Progress:
        """Of the sink that is furthest behind; of the sources where no stage is a sink."""
        senders = {edge.from_stage for edge in self.plan.edges}
        sinks = {stage.worker for stage in self.plan.stages if stage.name not in senders}
        fired = [worker.fired for worker in self.workers() if worker.name in sinks]
        newest = max((worker.time for worker in self.workers()), default=-1)
        return Progress(min(fired, default=0), newest, faults(self._seen_hosts(), self._seen()))

    def expected(self) -> int | None:
        """Frames that will be done, where a source knows."""
        return max((w.expected for w in self.workers() if w.expected is not None), default=None)

    def status(self) -> RunStatus:
        """For those who look on."""
        return RunStatus(
            tuple(self._seen()),
            tuple(self._ledger().words.tolist()),
            self.progress().fired,
            self.expected(),
            self._news(),
            self._clocks(),
            tuple(self._seen_hosts()),
        )

    def _seen_hosts(self) -> Iterator[SeenHost]:
        """All other hosts of which something is to be heard."""
        for name, status in self.hosts.items():
            if not name:
                continue
            if status.age_s is None and self.begun:
                yield SeenHost(name, None, absent=True)
            elif status.age_s is not None and not status.all("over"):
                yield SeenHost(name, status.age_s, absent=status.age_s > SILENCE)

    def _seen(self) -> Iterator[WorkerStatus]:
        """The workers with their hosts and ages; those of a host that does not answer are absent."""
        known = set()
        for host, status in self.hosts.items():
            age = status.age_s or 0.0
            for worker in status.workers:
                known.add(worker.name)
                if worker.phase == "over":
                    yield replace(worker, host=host)
                    continue
                phase = "absent" if age > SILENCE else worker.phase
                yield replace(worker, host=host, phase=phase, age_s=age + (worker.age_s or 0.0))
        for missing in self.plan.workers:
            if missing.name not in known and missing.host in self.hosts:  # else it is of another operator
                never = self.begun and self.hosts[missing.host].age_s is None
                yield WorkerStatus(missing.name, "absent" if never else "starting", host=missing.host)

    def report(self, seconds: float, silent: Mapping[str, str], *, stopped: bool) -> RunReport:
        """At the end, workers in the order of the plan. silent: hosts that do not answer, and why."""
        found = {worker.name: worker for worker in self.workers()}
        reports = [
            _report(found.get(w.name), silent.get(w.host, "nothing is known of how it ended"), w.name)
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
    if found is not None and found.report is not None:
        return found.report
    return WorkerReport(name, 0, error=f"worker {name} was not there at the end: {why}", absent=True)
