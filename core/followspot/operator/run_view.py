"""Merges the newest statuses of a run's hosts: its progress, its status, and its report at the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from followspot.control.clock_status import ClockStatus
from followspot.control.host import HostStatus, WorkerStatus
from followspot.control.progress import Progress
from followspot.control.swap import BEFORE_TAKE_OVER
from followspot.control.worker_report import WorkerReport
from followspot.graph.frame_count import sinks, sources
from followspot.graph.plan import Plan
from followspot.host.heartbeat import SILENCE
from followspot.operator.budgets import missed_budgets, overruns
from followspot.operator.change_under_way import host_names
from followspot.operator.reporting.report import RunReport, merge, summed_ledger
from followspot.operator.run_status import RunStatus, SeenHost, faults
from followspot.operator.sensor_end import ended_stages
from followspot.operator.stalls import stalled_edges
from followspot.worker.ledger import COLUMNS, Ledger


@dataclass(frozen=True)
class RunView:
    """One view of a run on all its hosts.

    hosts: the newest status of each, by name, "" for the operator's own; news: events that the operator
    itself noticed; begun: whether the run has started: a host without a status is then out of reach;
    plan_conflict: what differs between the plans of hosts, "" if nothing; changing: whether the operator
    leads a change.
    """

    plan: Plan
    hosts: Mapping[str, HostStatus]
    news: Sequence[str] = ()
    begun: bool = False
    plan_conflict: str = ""
    changing: bool = False

    def workers(self) -> Iterator[WorkerStatus]:
        """The workers of all hosts."""
        return (worker for status in self.hosts.values() for worker in status.workers)

    def progress(self) -> Progress:
        """Frames done by the sink that is furthest behind, or by the sources if the graph has no sink."""
        ends = {stage.worker for stage in sinks(self.plan)}
        fired = [worker.fired for worker in self.workers() if worker.name in ends]
        newest = max((worker.time for worker in self.workers()), default=-1)
        return Progress(
            min(fired, default=0),
            newest,
            (
                *filter(None, [self.unfinished_change()]),
                *faults(self._host_statuses(), self._worker_statuses()),
                *self.late(),
            ),
        )

    def unfinished(self) -> tuple[str, ...]:
        """The sinks of workers that have not ended."""
        over = {worker.name for worker in self.workers() if worker.phase == "over"}
        return tuple(stage.name for stage in sinks(self.plan) if stage.worker not in over)

    def awaited(self) -> tuple[str, ...]:
        """The silent hosts for which a run that would end goes on: all sources of other hosts have ended."""
        over = set(ended_stages(self.workers()))
        left = {self.plan.host_of_stage(name) for name in sources(self.plan) - over}
        silent = {host.name for host in self._host_statuses() if host.absent}
        return tuple(sorted(silent)) if self.expected() is not None and left <= silent else ()

    def expected(self) -> int | None:
        """Frames that the run will process; None if no source knows."""
        return max((w.expected for w in self.workers() if w.expected is not None), default=None)

    def status(self) -> RunStatus:
        """The status of the run, as the handle, the page and `top` show it."""
        return RunStatus(
            workers=tuple(self._worker_statuses()),
            counts=tuple(self._ledger().words.tolist()),
            fired=self.progress().fired,
            expected=self.expected(),
            news=self._news(),
            clocks=self._clocks(),
            hosts=tuple(self._host_statuses()),
            late=self.late(),
            unfinished_change=self.unfinished_change(),
        )

    def unfinished_change(self) -> str:
        """Remains of an interrupted change on hosts, as text; "" while the operator leads a change."""
        if self.changing:
            return ""
        built = [name for name, status in self.hosts.items() if status.change.phase in BEFORE_TAKE_OVER]
        if self.plan_conflict or not built:
            return self.plan_conflict
        line = f"{host_names(built)} built new stages that have not taken over: a change is under way, or was"
        return f"{line} interrupted, and others may have theirs already; if this stays, repeat the change"

    def late(self) -> tuple[str, ...]:
        """A line for each path that misses its budget."""
        return tuple(missed_budgets(self.plan, self._worker_statuses())) if self.plan.budgets else ()

    def stalled(self) -> tuple[str, ...]:
        """A line for each edge that stalls."""
        return tuple(stalled_edges(self._worker_statuses()))

    def _host_statuses(self) -> Iterator[SeenHost]:
        """The remote hosts that should answer: all whose workers have not ended."""
        for name, status in self.hosts.items():
            if not name:
                continue
            if status.age_s is None and self.begun:
                yield SeenHost(name, None, absent=True)
            elif status.age_s is not None and not status.all("over"):
                yield SeenHost(name, status.age_s, absent=status.age_s > SILENCE)

    def _worker_statuses(self) -> Iterator[WorkerStatus]:
        """All workers with their hosts and ages; the workers of a host that does not answer are absent."""
        known = set()
        for host, status in self.hosts.items():
            age = status.age_s or 0.0
            for worker in status.workers:
                known.add(worker.name)
                if worker.phase == "over":
                    yield replace(worker, host=host)
                    continue
                phase = "absent" if age > SILENCE else worker.phase
                yield replace(worker, host=host, phase=phase, age_s=worker.age_s or 0.0).later(age)
        for missing in self.plan.workers:
            if missing.name not in known and missing.host in self.hosts:  # else another operator watches it
                never = self.begun and self.hosts[missing.host].age_s is None
                yield WorkerStatus(missing.name, "absent" if never else "starting", host=missing.host)

    def report(self, seconds: float, silent: Mapping[str, str], *, stopped: bool) -> RunReport:
        """The final report, workers in the order of the plan. silent: hosts that do not answer, and why."""
        found = {worker.name: worker for worker in self.workers()}
        reports = [
            _report(found.get(w.name), silent.get(w.host) or self._why_unknown(w.host), w.name)
            for w in self.plan.workers
        ]
        return merge(
            self.plan,
            self._ledger(),
            reports,
            seconds,
            stopped=stopped,
            restarts={name: worker.restarts for name, worker in found.items()},
            news=(*self._news(), *overruns(self.plan, found.values())),
            clocks=self._clocks(),
            outs={name: status.out for name, status in self.hosts.items() if name},
        )

    def _why_unknown(self, host: str) -> str:
        """Why a worker of the host gave no report; a busy operator may not have found the host silent yet."""
        status = self.hosts.get(host)
        old = status is not None and status.age_s is not None and status.age_s > SILENCE
        return f"host {host} does not answer" if old else "nothing is known of how it ended"

    def _ledger(self) -> Ledger:
        return summed_ledger([status.counts for status in self.hosts.values()], self.plan.rows)

    def _news(self) -> tuple[str, ...]:
        news = [(name, line) for name, status in self.hosts.items() for line in status.news]
        lines = (f"{name}: {line}" if name else line for name, line in news)
        return (*self.news, *lines, *self._ledgers_left_out())

    def _ledgers_left_out(self) -> Iterator[str]:
        """A line for each host whose ledger is not in the sum because it does not fit the plan."""
        expected = COLUMNS * self.plan.rows
        for name, status in self.hosts.items():
            if self.begun and status.age_s is not None and len(status.counts) != expected:
                where = f"host {name}" if name else "this host"
                yield (
                    f"the ledger of {where} is left out of the sum: it has {len(status.counts)} counts, "
                    f"and the plan's edges have {expected}"
                )

    def _clocks(self) -> dict[str, ClockStatus]:
        """The clocks of the hosts that follow a reference clock."""
        return {name: status.clock for name, status in self.hosts.items() if status.clock.reference}


def _report(found: WorkerStatus | None, why: str, name: str) -> WorkerReport:
    """The worker's own report, or one that says why there is none."""
    if found is not None and found.report is not None:
        return found.report
    return WorkerReport(name, 0, error=f"worker {name} was not there at the end: {why}", absent=True)
