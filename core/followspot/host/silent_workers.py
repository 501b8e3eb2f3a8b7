"""Workers of a host that send nothing: hanging ones are killed, or the log names them."""

from __future__ import annotations

from collections.abc import Callable

from followspot.control.host import WorkerPhase
from followspot.host.heartbeat import LONG_SILENCE, SILENCE, Heartbeat
from followspot.host.worker_pool import WorkerPool
from followspot.host.worker_process import WorkerProcess
from followspot.log.record import Level


class SilentWorkers:
    """Finds the workers without a heartbeat. All times are monotonic, s.

    pool: has the workers; report_event: gets level and text of a line for the log, and the worker's name.
    """

    def __init__(self, pool: WorkerPool, report_event: Callable[[Level, str, str], None]) -> None:
        self._pool = pool
        self._report_event = report_event
        self._heartbeat = Heartbeat()
        self._named: set[tuple[str, int, WorkerPhase]] = set()
        """Workers that the log has named, each with its incarnation and phase."""

    def kill(self, now: float) -> None:
        """Kill the running workers that hang."""
        for worker in self._silent(now, SILENCE, "running"):
            if not worker.killed:
                line = f"worker {worker.name} (process {worker.process.pid}) hangs; it is killed"
                self._report_event("warning", line, worker.name)
                worker.kill("it hung")

    def name_running(self, now: float) -> None:
        """Name the running workers that hang in the log, once each: the run waits for them."""
        for worker in self._silent(now, LONG_SILENCE, "running"):
            line = f"worker {worker.name} (process {worker.process.pid}) has been silent for "
            line += f"{LONG_SILENCE:.0f} s: it hangs or was suspended, and the run waits for it"
            self._warn_once(worker, line)

    def name_starting(self, now: float) -> None:
        """Name the workers that take long to start in the log, once each."""
        for worker in self._silent(now, LONG_SILENCE, "starting"):
            line = f"worker {worker.name} has been starting for {LONG_SILENCE:.0f} s: "
            line += "a stage takes long to set up, or a process was suspended"
            self._warn_once(worker, line)

    def _warn_once(self, worker: WorkerProcess, line: str) -> None:
        """Log a warning, unless this start of the worker had one in the same phase."""
        key = worker.name, worker.incarnation, worker.phase
        if key not in self._named:
            self._named.add(key)
            self._report_event("warning", line, worker.name)

    def _silent(self, now: float, longest: float, phase: WorkerPhase) -> list[WorkerProcess]:
        """The workers in this phase without a heartbeat for `longest`, s."""
        workers = self._pool.workers
        heard = {worker.name: worker.heard for worker in workers.values()}
        silent = map(workers.__getitem__, self._heartbeat.silent(heard, now, longest))
        return [worker for worker in silent if worker.phase == phase and worker.busy]
