"""The operator's side of a run: all hosts ready, all begin, one report, whatever the hosts are."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Lock

from followspot.control.host import Host, HostLost, Others, RunOrder, WorkerStatus
from followspot.control.relay import Relayed, with_order
from followspot.errors import FollowspotError
from followspot.graph.change import changed_stages
from followspot.graph.move import moved
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_to_data
from followspot.host.clocks.host import reference
from followspot.log.merged import MergedLog
from followspot.log.record import Level, LogPage
from followspot.log.run_log import OnLog
from followspot.operator.changed import Changed, Moved, changed, with_change
from followspot.operator.hot_swap import change_hosts
from followspot.operator.move import move_hosts
from followspot.operator.progress import PROGRESS_PERIOD, OnProgress
from followspot.operator.report import RunReport
from followspot.operator.run_status import RunStatus
from followspot.operator.run_view import RunView
from followspot.worker.wiring import RunOptions

_GRACE = 20.0
"""Seconds that hosts have to end after a stop."""
_REUNION = 5.0
"""Seconds of these that a host has to answer again, to be told of the stop."""


def order_of(plan: Plan, options: RunOptions, *, restart: bool, detached: bool = False) -> RunOrder:
    """A new order. restart: whether workers that die are started again; detached: see `RunOrder`."""
    out = str(options.out.resolve())
    shipped, by = plan_to_data(plan), reference(plan)
    return RunOrder(uuid.uuid4().hex, shipped, options.frames, out, restart, detached, reference=by)


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
    ) -> None:
        """hosts: every host that the plan names; order: what they were, or are to be, told.

        others: those that may join while it runs; None for a run without a network; begun: whether it has,
        under another operator.
        """
        self.plan = plan
        self.hosts = list(hosts)
        self._others = others
        self.stopped = False
        self.log = MergedLog(hosts, on_log)
        self.order = order
        self.name = order.run
        self._leaving = False
        self._stop_asked = False
        self._ended: set[str] = set()
        """Workers whose end the hosts know of."""
        self._give_up_at: float | None = None
        self._silent: dict[str, str] = {}
        """Hosts that do not answer, and what is known of that."""
        self._news: list[str] = []
        self._one_change = Lock()
        self._begun = begun
        self._prepared = list(hosts) if begun else []
        self._early: list[Relayed] = []
        """Orders that came before the hosts had their parts."""
        self._one_relay = Lock()

    def stop(self) -> None:
        """End the sources everywhere; what is in flight is finished. Safe in a signal handler."""
        self.stopped = True
        self._stop_asked = True

    def execute(
        self, on_progress: OnProgress | None = None, on_begin: Callable[[], None] = lambda: None
    ) -> RunReport:
        """Start all workers together, run to the end, gather the report. Leaves nothing behind.

        on_begin: called when all have begun, or will not. Raises FollowspotError where a host refuses its
        part.
        """
        try:
            begun = self.begin()
            on_begin()
            return self.watch(on_progress if begun else None)
        finally:
            self._close()

    def begin(self) -> bool:
        """Prepare all hosts and start them together; whether all were ready. Raises FollowspotError."""
        for host in self.hosts:
            host.prepare(self.order)
            self._relay_to(host)
        if not self._all_ready():
            self._end_early()
            return False
        for host in self.hosts:
            host.start()
        self._begun = True
        return True

    def _close(self) -> None:
        """Leave nothing behind; say where that was not possible."""
        for host in self.hosts:
            if not host.close():
                line = f"host {host.name} was not told that the run is over; its part ends after the agent's "
                line += f"--operator-timeout, or by followspot attach {self.name[:8]} --stop"
                self._tell_news(line, "warning")

    def watch(self, on_progress: OnProgress | None = None) -> RunReport:
        """Look on to the end of a run that has begun, or until `leave`."""
        started = time.monotonic()
        self._attend(on_progress)
        self.log.gather()
        return self._view().report(time.monotonic() - started, self._silent, stopped=self.stopped)

    def status(self) -> RunStatus:
        """The newest picture of the whole run."""
        return self._view().status()

    def change(self, words: Sequence[str], folder: Path, *, fresh: bool = False) -> Changed:
        """Swap stages and set parameters while the run goes on; safe beside the thread that watches.

        words, folder: as `changed_stages` takes them; fresh: without the state of the old stages. Raises
        InputError, or FollowspotError where a successor cannot be built or cannot carry on: the old ones do.
        """
        with self._one_change:
            self._check_begun()
            stages = changed_stages(self.plan, words, folder)
            report = changed(self.name, self.plan, stages)
            if stages:
                change_hosts(self.plan, self.hosts, stages, fresh=fresh)
                self.plan = with_change(self.plan, stages)
            return report

    def move(self, names: Sequence[str], place: str) -> Moved:
        """Bring stages of a live run to another worker or host; safe beside the thread that watches.

        Workers whose stages or kinds of edges change begin anew, with the state of their stages; what is
        under way to and from them is lost, and counted. Raises InputError, FollowspotError.
        """
        with self._one_change:
            self._check_begun()
            new = moved(self.plan, names, place, self._others.names() if self._others else ())
            report = Moved.of(self.name, self.plan, new)
            if report.stages:
                self._join({worker.host for worker in new.workers} - {host.name for host in self.hosts})
                move_hosts(self.plan, new, self.hosts)
                self.plan = replace(new, notes=(*new.notes, f"while it ran: {report.text}"))
            return report

    def _join(self, names: Iterable[str]) -> None:
        """Let hosts take part in the run, with no workers yet. Raises FollowspotError where one refuses."""
        for name in names:
            assert self._others is not None
            host = self._others.host(name)
            over = tuple(sorted(self._ended))
            host.prepare(replace(self.order, plan=plan_to_data(self.plan), incarnations={}, over=over))
            host.start()
            self._relay_to(host)
            self.order = replace(self.order, reference=self.order.reference or name)
            self.hosts.append(host)
            self.log.join(host)

    def _check_begun(self) -> None:
        if not self._begun:
            raise FollowspotError("the run has not begun yet; try again in a moment")

    def relay(self, order: Relayed) -> None:
        """Tell all workers, as soon as their hosts have their parts; safe from any thread.

        Raises FollowspotError if a run of this plan refuses the order.
        """
        order.check(self.plan, remote=False)
        with self._one_relay:
            if not self._begun:
                self._early = with_order(self._early, order)
            for host in self._prepared:
                host.relay(order)

    def _relay_to(self, host: Host) -> None:
        """The host has its part: tell it what came before."""
        with self._one_relay:
            self._prepared.append(host)
            for order in self._early:
                host.relay(order)

    def records(self, after: int) -> LogPage:
        """What was logged on all hosts after the record of this number; safe from any thread."""
        self.log.gather()
        return self.log.after(after)

    def leave(self) -> None:
        """Look on no longer; the run goes on. Safe in a signal handler."""
        self._leaving = True

    def _all_ready(self) -> bool:
        """Wait for every worker everywhere; False where one failed or the user stopped."""
        while not all(worker.phase == "ready" for worker in self._workers()):
            self._look(None)
            if self._stop_asked or self._failed():
                return False
        return True

    def _attend(self, on_progress: OnProgress | None) -> None:
        """Watch until every worker has ended, or nobody can tell."""
        while not (self._leaving or all(self._over(host) for host in self.hosts)):
            self._look(on_progress)
            if self._stop_asked or self._failed():
                self._end_early()
            if self._give_up_at is not None and time.monotonic() > self._give_up_at:
                return
            if self.order.restart:
                self._tell_ends()

    def _tell_ends(self) -> None:
        """Let all hosts know which workers have come to their end, where those that die are started again."""
        ended = {worker.name for worker in self._workers() if worker.phase == "over"}
        if not ended <= self._ended:
            self._ended |= ended
            for host in self.hosts:
                host.ended(sorted(self._ended))

    def _look(self, on_progress: OnProgress | None) -> None:
        for host in self.hosts:
            try:
                host.attend(PROGRESS_PERIOD / len(self.hosts))
                if self._silent.pop(host.name, None):
                    self._tell_news(f"host {host.name} is back", "info")
            except HostLost as error:
                if host.name not in self._silent:
                    self._tell_news(str(error), "warning")
                self._silent[host.name] = str(error)
        self.log.gather()
        if on_progress is not None:
            whole = self._view()
            on_progress(whole.progress(), whole.expected())

    def _tell_news(self, line: str, level: Level) -> None:
        self.log.say(level, line)
        self._news.append(line)

    def _end_early(self) -> None:
        """Ask every worker to finish what is in flight; once."""
        self._stop_asked = False
        if self._give_up_at is None:
            self._give_up_at = time.monotonic() + _GRACE
            for host in self.hosts:
                host.stop()

    def _over(self, host: Host) -> bool:
        """Whether nothing more is to be expected of a host."""
        if host.name in self._silent:
            parted = self._give_up_at is not None and time.monotonic() > self._give_up_at - _GRACE + _REUNION
            return parted or not self.order.restart
        return host.status().all("over")

    def _failed(self) -> bool:
        """Whether something ended in a way that ends the run."""
        lost = bool(self._silent) and not self.order.restart
        return lost or any(w.phase == "over" and w.report and w.report.error for w in self._workers())

    def _workers(self) -> Iterator[WorkerStatus]:
        return self._view().workers()

    def _view(self) -> RunView:
        hosts = {host.name: host.status() for host in self.hosts}
        return RunView(self.plan, hosts, self._news, self._begun)
