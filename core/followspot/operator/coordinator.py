"""The operator's side of a run: prepares all hosts, starts them together, watches them, merges a report."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from followspot.control.host import Host, Others, RunOrder, WorkerStatus
from followspot.control.lifecycle import EndWorkers, StartRun
from followspot.control.progress import PROGRESS_PERIOD, OnProgress
from followspot.control.relay import Relayed
from followspot.control.worker_orders import EndSensors
from followspot.errors import FollowspotError
from followspot.graph.frame_count import accompanying_sources
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.log.merged import MergedLog
from followspot.log.record import LogPage
from followspot.log.run_log import OnLog
from followspot.operating_system.limits import limit_remedy
from followspot.operator.change_under_way import ChangeUnderWay
from followspot.operator.host_plans import PlanConflict
from followspot.operator.order_relay import OrderRelay
from followspot.operator.reporting.report import RunReport
from followspot.operator.run_end import RunEnd
from followspot.operator.run_events import RunEvents
from followspot.operator.run_status import RunStatus
from followspot.operator.run_view import RunView
from followspot.operator.sensor_end import order_at_end, order_at_start
from followspot.operator.silent_hosts import SilentHosts

_LIMITS = "raise the limits of this user, see ulimit -a, or take fewer workers: --placement"
"""Remedy if the system refuses a run its workers for a reason of its own."""
_CHANGE_TIMEOUT = 5.0
"""Seconds that a change under way has, after the end of the run, to find that out."""


class Coordinator:
    """A run of a plan on one host or many."""

    def __init__(
        self,
        plan: Plan,
        hosts: Sequence[Host],
        order: RunOrder,
        on_log: OnLog | None = None,
        others: Others | None = None,
        *,
        begun: bool = False,
        age_s: float = 0.0,
    ) -> None:
        """hosts: every host that the plan names; order: the order that the hosts get, or have got already.

        others: hosts that may join during the run; None for a run without a network; begun: whether another
        operator has started the run already, and age_s: how long ago, s.
        """
        self.plan = plan
        self.hosts = list(hosts)
        self.others = others
        self.stopped = False
        self.log = MergedLog(hosts, on_log)
        self.order = order
        self.name = order.run
        self._leaving = False
        self._stop_asked = False
        self._ended: set[str] = set()
        """Workers that have ended, as announced to the hosts."""
        self._events = RunEvents(self.log)
        self._silent = SilentHosts(self._events)
        self._end = RunEnd(self.hosts, self._silent, restart=order.restart)
        self.change = ChangeUnderWay()
        self.plan_conflict: PlanConflict | None = None
        """The conflict between the plans of hosts, if an earlier operator died in the middle of a change."""
        self._sensors_ended = False
        """Whether the order that ends the sensors was sent."""
        self._begun = begun
        self._age_s = age_s
        self._order_relay = OrderRelay(hosts if begun else ())

    def stop(self) -> None:
        """End all sources; workers finish the messages in flight. Safe in a signal handler."""
        self.stopped = True
        self._stop_asked = True

    def execute(
        self, on_progress: OnProgress | None = None, on_begin: Callable[[], None] = lambda: None
    ) -> RunReport:
        """Start all workers together, run to the end, return the report, and close all hosts.

        on_begin: called once all workers have started, or once it is known that they will not. Raises
        FollowspotError if a host refuses its workers.
        """
        try:
            begun = self.begin()
            on_begin()
            return self.watch(on_progress if begun else None)
        finally:
            self._close()

    def begin(self) -> bool:
        """Prepare all hosts and start them together; False if not all got ready. Raises FollowspotError."""
        for host in self.hosts:
            try:
                host.prepare(self.order)
            except OSError as error:
                text = f"the workers cannot be started: {error.strerror}"
                raise FollowspotError(f"{text}\n    {limit_remedy(error, _LIMITS)}") from None
            self._order_relay.add(host)
        if not self._all_ready():
            self._end_early()
            return False
        self._end_sensors(order_at_start)
        for host in self.hosts:
            host.ask(StartRun())
        self._begun = True
        return True

    def _close(self) -> None:
        """Close all hosts; log a warning for each that does not answer."""
        for host in self.hosts:
            if not host.close():
                line = f"host {host.name} was not told that the run is over; its workers end after the "
                line += f"agent's --operator-timeout, or by followspot attach --run {self.name[:8]} --stop"
                self._events.add(line, "warning")

    def watch(self, on_progress: OnProgress | None = None) -> RunReport:
        """Block until a run that has begun ends, or until `leave`; return its report."""
        started = time.monotonic() - self._age_s
        self._watch_to_end(on_progress)
        self._await_change()
        self._silent.renew(self.hosts)
        self.log.gather()
        report = self._view().report(time.monotonic() - started, self._silent.reasons, stopped=self.stopped)
        cut_short = self._end.cut_short
        errors = (cut_short,) if cut_short and report.ok else report.errors
        return replace(report, begun=self._begun, errors=errors)

    def status(self) -> RunStatus:
        """The newest status of the whole run."""
        return replace(self._view().status(), change_awaits=self.change.waits_for)

    @contextmanager
    def one_change(self) -> Iterator[None]:
        """Make changes and moves of a run wait for each other. Raises FollowspotError before it has begun."""
        with self.change.alone():
            if not self._begun:
                raise FollowspotError("the run has not begun yet; try again in a moment")
            yield

    def join(self, names: Iterable[str]) -> None:
        """Add hosts to the run, with no workers yet. Raises FollowspotError if a host refuses."""
        for name in names:
            assert self.others is not None
            self.change.wait_for(f"host {name} to join the run")
            host = self.others.host(name)
            over = tuple(sorted(self._ended))
            host.prepare(replace(self.order, plan=plan_to_data(self.plan), incarnations={}, over=over))
            host.ask(StartRun())
            self._order_relay.add(host)
            self.order = replace(self.order, reference=self.order.reference or name)
            self.hosts.append(host)
            self.log.join(host)

    def relay(self, order: Relayed) -> None:
        """Send an order to all workers, once their hosts are prepared. Safe from any thread.

        Raises FollowspotError if the order does not fit the plan.
        """
        order.check(self.plan, remote=False)
        self._order_relay.send(order, keep=not self._begun)

    def records(self, after: int) -> LogPage:
        """Log records of all hosts after the record of this number. Safe from any thread."""
        self.log.gather()
        return self.log.after(after)

    def leave(self) -> None:
        """Make `watch` return while the run goes on. Safe in a signal handler."""
        self._leaving = True

    def _all_ready(self) -> bool:
        """Wait until all workers are ready; False if one failed or the user stopped the run."""
        while not all(worker.phase == "ready" for worker in self._workers()):
            self._poll_hosts(None)
            if self._stop_asked or self._end.failed():
                return False
        return True

    def _watch_to_end(self, on_progress: OnProgress | None) -> None:
        """Poll until every worker has ended or is on a host that no longer answers."""
        while not (self._leaving or self._end.over()):
            self._poll_hosts(on_progress)
            self._end_sensors(order_at_end)
            if self._stop_asked or self._end.failed():
                self._end_early()
            if self._end.timed_out():
                return
            if self.order.restart:
                self._announce_ended_workers()

    def _await_change(self) -> None:
        """Wait until a change under way ends: if it was made, the ledger of the hosts has its edges."""
        deadline = time.monotonic() + _CHANGE_TIMEOUT
        while self.change.under_way and not self._leaving and time.monotonic() < deadline:
            self._poll_hosts(None)

    def _end_sensors(self, order_of: Callable[[Plan, Iterable[WorkerStatus]], EndSensors | None]) -> None:
        """Send the order that ends the sensors of a run of N frames, as soon as it is known."""
        if self._sensors_ended or self.order.frames is None or not accompanying_sources(self.plan):
            return
        order = order_of(self.plan, self._workers())
        if order is not None:
            self._sensors_ended = True
            self.relay(order)

    def _announce_ended_workers(self) -> None:
        """Tell all hosts which workers have ended, so that a restarted worker does not wait for them."""
        ended = {worker.name for worker in self._workers() if worker.phase == "over"}
        if not ended <= self._ended:
            self._ended |= ended
            for host in self.hosts:
                host.ask(EndWorkers(workers=tuple(sorted(self._ended))))

    def _poll_hosts(self, on_progress: OnProgress | None) -> None:
        """Take the newest status of each host, and report what has changed."""
        for host in self.hosts:
            self._silent.attend(host, PROGRESS_PERIOD / len(self.hosts))
            self._end.note_loss(host)
        stopping = self._end.stopping
        self._events.notice(self._view(), silence=bool(self._silent.reasons) and not stopping)
        self.log.gather()
        if on_progress is not None:
            view = self._view()
            unfinished = view.unfinished() if stopping else ()
            on_progress(replace(view.progress(), unfinished=unfinished), view.expected())

    def _end_early(self) -> None:
        self._stop_asked = False
        self._end.stop()

    def _workers(self) -> Iterator[WorkerStatus]:
        return self._view().workers()

    def _view(self) -> RunView:
        hosts = {host.name: host.status() for host in self.hosts}
        conflict = "" if self.plan_conflict is None else self.plan_conflict.text
        changing = bool(self.change.waits_for)
        return RunView(self.plan, hosts, self._events.lines, self._begun, conflict, changing)
