"""Looks after the workers of a host: lets them begin, kills those that hang, starts those that died."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from followspot.control.lifecycle import StopRun
from followspot.control.move import MoveOrder
from followspot.control.worker_orders import LeaveRun, SendStates
from followspot.control.worker_report import WorkerReport
from followspot.host.clocks.host import HostClock
from followspot.host.heartbeat import Heartbeat, RestartPolicy, fed
from followspot.host.worker_pool import WorkerPool
from followspot.host.worker_process import WorkerProcess
from followspot.log.record import Level

_GRACE = 15.0
"""Seconds that workers have to drain after a stop before they are killed."""
_SNAPSHOT_PERIOD = 1.0
"""Seconds between two pictures of the state of a worker's stages, where workers are restarted."""


class Supervisor:
    """Decides what becomes of each worker of a worker pool.

    clock: what workers that are started are told of it; tell: gets news and errors, and whose they are.
    """

    def __init__(self, pool: WorkerPool, clock: HostClock, tell: Callable[[Level, str, str], None]) -> None:
        self._pool = pool
        self._clock = clock
        self._tell = tell
        self._running = self._stopping = False
        self._left: set[str] = set()
        """Workers that have left their place, or are about to, until the pool is rearranged."""
        self._latest = 0
        """Highest incarnation that a move has given."""
        self._dead: set[str] = set()
        """Workers that died and are not at work again."""
        self._missing: frozenset[str] = frozenset()
        """Those of them when the run was stopped."""
        self._snapshot_at = 0.0
        self._kill_at: float | None = None
        self._heartbeat = Heartbeat()
        self._restarts = RestartPolicy()

    def prepare(self) -> None:
        """Start all that have not come to their end before. Raises OSError."""
        for name in self._pool.names():
            if name not in self._pool.over:
                incarnation = self._pool.order.incarnations.get(name, 0)
                self._pool.spawn(name, incarnation, self._clock.correction())

    def start(self) -> None:
        """Let all begin at once."""
        self._running = True
        for worker in self._pool.workers.values():
            if worker.phase == "ready":  # else it begins when it is
                self._pool.begin(worker)

    def stop(self) -> None:
        """Ask all to finish what is in flight; once."""
        if self._stopping:
            return
        self._stopping = True
        self._missing = frozenset(self._dead)
        self._kill_at = time.monotonic() + _GRACE
        self._pool.tell(StopRun())
        for name in self._restarts.waiting:
            self._give_up(self._pool.workers[name], error=_gone(name))
        for name in self._left:
            self._give_up(self._pool.workers[name], error="")

    def look(self, now: float) -> None:
        """See what has become of the workers, and do what is to be done. now: the time, s."""
        for worker in tuple(self._pool.workers.values()):
            self._see_to(worker, now)
        if self._at_work():
            self._kill_silent(now)
            for name in self._restarts.due(now):
                self._spawn_again(name, self._pool.workers[name].incarnation + 1)
            if now >= self._snapshot_at:
                self._snapshot_at = now + _SNAPSHOT_PERIOD
                self._ask_for_states()
        if self._kill_at is not None and now > self._kill_at:
            self._kill_at = None
            for worker in self._pool.workers.values():
                if worker.busy:
                    worker.kill(f"it did not end within {_GRACE:.0f} s of the stop")

    def rearrange(self, order: MoveOrder) -> None:
        """Let workers leave, or let all take the places that a plan gives them."""
        leaving = [name for name in order.leaving if name in self._pool.workers]
        self._left.update(leaving)
        for name in leaving:
            self._restarts.call_off(name)
            self._pool.workers[name].tell(LeaveRun())
        if order.plan is None:
            return
        present = (worker.incarnation for worker in self._pool.workers.values())
        self._latest = 1 + max(self._latest, *present, 0)  # above that of workers that are gone, too
        for name in self._pool.rearrange(order.plan, order.states, self._left):
            self._spawn_again(name, self._latest)
        self._left.clear()

    def _at_work(self) -> bool:
        """Whether workers that die are started again."""
        return self._pool.order.restart and self._running and not self._stopping

    def _see_to(self, worker: WorkerProcess, now: float) -> None:
        """Let a worker that was started again begin; notice one that has reported, or died."""
        if worker.phase == "ready" and self._running:
            self._pool.join(worker)
            self._dead.discard(worker.name)
            self._tell("info", f"worker {worker.name} is back", worker.name)
        if worker.phase in ("over", "absent") or worker.busy:
            return
        report = worker.report
        failed_again = report is not None and bool(report.error) and worker.incarnation and worker.fired == 0
        if report is not None and not failed_again:
            worker.phase = "over"
            if worker.name in self._missing and not report.error:
                worker.report = report = replace(report, error=_gone(worker.name), absent=True)
            if report.error:
                self._tell("error", report.error, worker.name)
            return
        if report is None and worker.process.poll() is None:
            worker.process.kill()
        self._died(worker, worker.obituary() if report is None else report.error, now)

    def _died(self, worker: WorkerProcess, why: str, now: float) -> None:
        """Start it again after a while, unless nothing would come to it any more."""
        if not (self._at_work() and fed(self._pool.plan, worker.name, self._pool.over)):
            why = f"{_gone(worker.name)}: {why}" if worker.name in self._missing else why
            self._give_up(worker, error="" if worker.name in self._left else why)
            return
        worker.phase = "absent"
        if worker.name not in self._left:
            self._dead.add(worker.name)
            wait = self._restarts.after_death(worker.name, now)
            self._tell("warning", f"{why}; it is started again in {wait:.1f} s", worker.name)

    def _give_up(self, worker: WorkerProcess, error: str) -> None:
        """The worker has ended without a report, for good."""
        self._restarts.call_off(worker.name)
        worker.phase = "over"
        if error:
            self._tell("error", error, worker.name)
        warnings = () if error else (f"worker {worker.name} was not there at the end",)
        worker.report = WorkerReport(worker.name, 0, warnings=warnings, error=error, absent=True)

    def _kill_silent(self, now: float) -> None:
        """Those that hang."""
        workers = self._pool.workers
        for name in self._heartbeat.silent({w.name: w.heard for w in workers.values()}, now):
            worker = workers[name]
            if worker.phase == "running" and worker.busy and not worker.killed:
                line = f"worker {name} (process {worker.process.pid}) hangs; it is killed"
                self._tell("warning", line, name)
                worker.kill("it hung")

    def _ask_for_states(self) -> None:
        for worker in self._pool.workers.values():
            if worker.phase == "running":
                worker.tell(SendStates())

    def _spawn_again(self, name: str, incarnation: int) -> None:
        self._pool.spawn(name, incarnation, self._clock.correction(), again=True)


def _gone(worker: str) -> str:
    """The error of a run that ends while a worker is away: what came to it meanwhile was not processed."""
    return f"worker {worker} was not there at the end: it had died, and was not back at work yet"
