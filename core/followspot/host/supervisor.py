"""The supervisor of a host's workers: starts their stages, kills hanging workers, restarts dead ones."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from followspot.control.lifecycle import StopRun
from followspot.control.move import MOVE_TIMEOUT, MoveOrder
from followspot.control.worker_orders import LeaveRun, SendStates
from followspot.control.worker_report import WorkerReport
from followspot.host.clocks.host import HostClock
from followspot.host.restart_notes import RestartNotes
from followspot.host.restart_policy import RestartPolicy, may_get_messages
from followspot.host.silent_workers import SilentWorkers
from followspot.host.worker_pool import WorkerPool
from followspot.host.worker_process import WorkerProcess
from followspot.log.record import Level

_STOP_TIMEOUT = 15.0
"""Seconds that workers have to finish after a stop before they are made to leave."""
_LEAVE_TIMEOUT = 2.0
"""Seconds that they have then to complete their outputs before they are killed."""
_CHECKPOINT_PERIOD = 1.0
"""Seconds between two checkpoints of a worker's stages, in runs that restart workers."""


class Supervisor:
    """Decides when the workers of a pool are started, killed and restarted.

    clock: has the clock correction for new workers; report_event: gets news and errors, each with its worker.
    """

    def __init__(
        self, pool: WorkerPool, clock: HostClock, report_event: Callable[[Level, str, str], None]
    ) -> None:
        self._pool = pool
        self._clock = clock
        self._report_event = report_event
        self._running = self._stopping = False
        self._leaving: set[str] = set()
        """Workers that have left or are told to leave: for a move, until the pool has the new plan; after a
        stop, if they do not end in time."""
        self._back_at: float | None = None
        """When workers that left for a move start again if no new plan comes, monotonic, s."""
        self.move_given_up = False
        """True if workers of the newest move started again at their old places because no new plan came."""
        self._latest = 0
        """Highest incarnation of any worker that a move has started."""
        self._dead: set[str] = set()
        """Workers that died and have not been restarted yet."""
        self._dead_at_stop: frozenset[str] = frozenset()
        """Workers that were dead when the run was stopped."""
        self._checkpoint_at = 0.0
        self._kill_at: float | None = None
        self._silent = SilentWorkers(pool, report_event)
        self._restarts = RestartPolicy()
        self._notes = RestartNotes()

    def prepare(self) -> None:
        """Start all workers that have not ended before. Raises OSError."""
        for name in self._pool.names():
            if name not in self._pool.over:
                incarnation = self._pool.order.incarnations.get(name, 0)
                self._pool.spawn(name, incarnation, self._clock.correction())

    def start(self) -> None:
        """Start the stages of all workers."""
        self._running = True
        for worker in self._pool.workers.values():
            if worker.phase == "ready":  # the others begin when they are ready
                self._pool.begin(worker)

    def stop(self) -> None:
        """Ask all workers to finish the messages in flight, once."""
        if self._stopping:
            return
        self._stopping = True
        self._dead_at_stop = frozenset(self._dead)
        self._kill_at = time.monotonic() + _STOP_TIMEOUT
        self._pool.send_to_all(StopRun())
        for name in self._restarts.waiting:
            self._end_without_report(self._pool.workers[name], error=_absent_at_end(name))
        for name in self._leaving:
            self._end_without_report(self._pool.workers[name], error="")

    def check(self, now: float) -> None:
        """Check all workers; kill, restart and checkpoint them as needed. now: monotonic time, s."""
        for worker in tuple(self._pool.workers.values()):
            self._attend_worker(worker, now)
        if self._restarting():
            self._silent.kill(now)
            for name in self._restarts.due(now):
                self._spawn_again(name, self._pool.workers[name].incarnation + 1)
            if self._back_at is not None and now >= self._back_at:
                self._bring_back()
            if now >= self._checkpoint_at:
                self._checkpoint_at = now + _CHECKPOINT_PERIOD
                self._request_checkpoints()
        elif self._running and not self._stopping:
            self._silent.name_running(now)
        self._silent.name_starting(now)
        if self._kill_at is not None and now > self._kill_at:
            self._end_late(now)

    def _end_late(self, now: float) -> None:
        """Order workers that have not ended after a stop to leave; the next time, kill them.

        Most of them only wait for another worker whose stage does not return: they can complete their outputs
        and leave.
        """
        late = [worker for worker in self._pool.workers.values() if worker.busy]
        if all(worker.name in self._leaving for worker in late):
            self._kill_at = None
            for worker in late:
                self._leaving.discard(worker.name)
                worker.kill(f"it did not end within {_STOP_TIMEOUT:.0f} s of the stop{worker.at_work()}")
            return
        self._kill_at = now + _LEAVE_TIMEOUT
        self._leaving.update(worker.name for worker in late)
        for worker in late:
            worker.channel.send_if_open(LeaveRun())

    def rearrange(self, order: MoveOrder) -> None:
        """Do one step of a move: let workers leave, or start those that a new plan needs."""
        leaving = [name for name in order.leaving if name in self._pool.workers]
        self._leaving.update(leaving)
        if order.leaving:
            self.move_given_up = False
        if leaving:
            self._back_at = time.monotonic() + MOVE_TIMEOUT
        for name in leaving:
            self._restarts.call_off(name)
            self._pool.workers[name].channel.send_if_open(LeaveRun())
        if order.plan is None:
            return
        present = (worker.incarnation for worker in self._pool.workers.values())
        self._latest = 1 + max(self._latest, *present, 0)  # also higher than those of removed workers
        for name in self._pool.rearrange(order.plan, order.states, self._leaving):
            self._spawn_again(name, self._latest, order.fired.get(name))
        self._leaving.clear()
        self._back_at = None

    def all_left(self) -> bool:
        """True if every worker that was told to leave has ended."""
        workers = self._pool.workers
        return all(workers[name].phase in ("absent", "over") for name in self._leaving if name in workers)

    def _bring_back(self) -> None:
        """Restart workers that left for a move at their old places: no operator has completed the move."""
        back, self._back_at = sorted(self._leaving), None
        self._leaving.clear()
        self.move_given_up = True
        line = f"worker {', '.join(back)} begins again at its old place: the move was not ended"
        self._report_event("warning", f"{line} within {MOVE_TIMEOUT:.0f} s", back[0])
        for name in back:
            worker = self._pool.workers[name]
            if worker.phase == "absent":
                self._spawn_again(name, worker.incarnation + 1)

    def _restarting(self) -> bool:
        """True if the supervisor restarts workers that die now."""
        return self._pool.order.restart and self._running and not self._stopping

    def _attend_worker(self, worker: WorkerProcess, now: float) -> None:
        """Start the stages of a restarted worker that is ready; take note if a worker has ended or died."""
        if worker.phase == "ready" and self._running:
            self._pool.join(worker)
            self._dead.discard(worker.name)
            self._report_event("info", f"worker {worker.name} is back", worker.name)
        if worker.phase in ("over", "absent") or worker.busy:
            return
        report = worker.report
        failed_again = report is not None and bool(report.error) and worker.incarnation and worker.fired == 0
        if report is not None and not failed_again:
            worker.phase = "over"
            if worker.name in self._dead_at_stop and not report.error:
                worker.report = report = replace(report, error=_absent_at_end(worker.name), absent=True)
            if report.error:
                self._report_event("error", report.error, worker.name)
            return
        if report is None and worker.process.poll() is None:
            worker.process.kill()
        self._died(worker, worker.exit_reason() if report is None else report.error, now)

    def _died(self, worker: WorkerProcess, why: str, now: float) -> None:
        """Schedule a restart, unless no more messages can reach the worker."""
        if not (self._restarting() and may_get_messages(self._pool.plan, worker.name, self._pool.over)):
            why = f"{_absent_at_end(worker.name)}: {why}" if worker.name in self._dead_at_stop else why
            self._end_without_report(worker, error="" if worker.name in self._leaving else why)
            return
        if worker.name not in self._leaving:
            self._dead.add(worker.name)
            wait = self._restarts.after_death(worker.name, now)
            self._report_event("warning", self._notes.of(worker.name, why, wait), worker.name)
        worker.phase = "absent"  # last: the log has the reason before the phase shows

    def _end_without_report(self, worker: WorkerProcess, error: str) -> None:
        """Mark a worker as ended for good, with a report in its place."""
        self._restarts.call_off(worker.name)
        worker.phase = "over"
        if error:
            self._report_event("error", error, worker.name)
        warnings = () if error else (f"worker {worker.name} was not there at the end",)
        worker.report = WorkerReport(worker.name, 0, warnings=warnings, error=error, absent=True)

    def _request_checkpoints(self) -> None:
        for worker in self._pool.workers.values():
            if worker.phase == "running":
                worker.channel.send_if_open(SendStates())

    def _spawn_again(self, name: str, incarnation: int, fired: int | None = None) -> None:
        self._pool.spawn(name, incarnation, self._clock.correction(), again=True, fired=fired)


def _absent_at_end(worker: str) -> str:
    """The error of a run that ends while a worker is dead, because messages to it were not processed."""
    return f"worker {worker} was not there at the end: it had died, and was not back at work yet"
