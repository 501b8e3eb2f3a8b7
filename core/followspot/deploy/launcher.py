"""The launcher: one process a worker, a barrier before the start, one report, nothing left behind."""

from __future__ import annotations

import mmap
import os
import selectors
import signal
import socket
import subprocess
import sys
import time
import uuid
from typing import Any

from followspot.deploy.channel import Channel, ChannelClosed
from followspot.deploy.links import ring_edges, socket_pair, uses_zenoh
from followspot.deploy.local import PROGRESS_PERIOD, OnProgress
from followspot.deploy.report import RunReport, WorkerReport, merge
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_to_data
from followspot.runtime.ledger import COLUMNS, Ledger
from followspot.runtime.wiring import RunOptions
from followspot.runtime.worker import Progress

_GRACE = 15.0
"""Seconds that workers have to drain after a stop before they are killed."""
_PATIENCE = 5.0
"""Seconds that a worker that has reported may take to exit."""


class WorkerProcess:
    """One worker as the launcher sees it."""

    def __init__(self, name: str, process: subprocess.Popen[bytes], channel: Channel) -> None:
        self.name = name
        self.process = process
        self.channel = channel
        self.ready = False
        self.fired = 0
        self.time = -1
        self.expected: int | None = None
        self.locators: list[str] = []
        self.report: WorkerReport | None = None

    def obituary(self) -> str:
        """How the process ended that did not report."""
        code = self.process.wait()
        how = f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"worker {self.name} (process {self.process.pid}) died: {how}"


class ProcessRun:
    """A run of a plan with several workers on this host."""

    def __init__(self, plan: Plan, options: RunOptions) -> None:
        self.plan = plan
        self.options = options
        self.stopped = False
        self.run = uuid.uuid4().hex
        self.workers: list[WorkerProcess] = []
        self._ledger_fd = os.memfd_create("followspot-ledger", os.MFD_CLOEXEC)
        size = max(1, len(plan.edges) * COLUMNS * 8)
        os.ftruncate(self._ledger_fd, size)
        self.ledger = Ledger(len(plan.edges), memoryview(mmap.mmap(self._ledger_fd, size)).cast("q"))
        self._selector = selectors.DefaultSelector()
        self._stop_asked = False
        self._kill_at: float | None = None

    def stop(self) -> None:
        """End the sources everywhere; what is in flight is finished. Safe in a signal handler."""
        self.stopped = True
        self._stop_asked = True

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Start all workers together, run to the end, gather the report. Leaves no process behind."""
        started = time.monotonic()
        try:
            self._spawn()
            if self._barrier():
                started = time.monotonic()
                self._attend(on_progress)
            else:
                self._call_off()
            seconds = time.monotonic() - started
            reports = [self._report(worker) for worker in self.workers]
        finally:
            self._kill_all()
        return merge(self.plan, self.ledger, reports, seconds, stopped=self.stopped)

    def _spawn(self) -> None:
        """Start all processes, each with its ends of the rings, then tell each what it is."""
        pairs = {number: socket_pair() for number in ring_edges(self.plan)}
        home = {stage.name: stage.worker for stage in self.plan.stages}
        edges = self.plan.edges
        ends = []
        for planned in self.plan.workers:
            sending = {
                n: p[0].fileno() for n, p in pairs.items() if home[edges[n].from_stage] == planned.name
            }
            receiving = {
                n: p[1].fileno() for n, p in pairs.items() if home[edges[n].to_stage] == planned.name
            }
            self.workers.append(self._start_process(planned.name, [*sending.values(), *receiving.values()]))
            ends.append((sending, receiving))
        for pair in pairs.values():
            pair[0].close()
            pair[1].close()
        plan = plan_to_data(self.plan)
        for worker, (sending, receiving) in zip(self.workers, ends, strict=True):
            self._order(worker, plan, sending, receiving)

    def _start_process(self, name: str, fds: list[int]) -> WorkerProcess:
        ours, theirs = socket.socketpair()
        process = subprocess.Popen(
            [sys.executable, "-m", "followspot.deploy.child", str(theirs.fileno())],
            pass_fds=[theirs.fileno(), self._ledger_fd, *fds],
            stdin=subprocess.DEVNULL,
        )
        theirs.close()
        worker = WorkerProcess(name, process, Channel(ours))
        self._selector.register(worker.channel, selectors.EVENT_READ, worker)
        return worker

    def _order(
        self, worker: WorkerProcess, plan: dict[str, Any], sending: dict[int, int], receiving: dict[int, int]
    ) -> None:
        """Tell a worker what it is. With Zenoh each connects to those before it, so wait for its address."""
        worker.channel.send(
            "plan",
            worker=worker.name,
            plan=plan,
            sending=sending,
            receiving=receiving,
            ledger=self._ledger_fd,
            out=str(self.options.out.resolve()),
            frames=self.options.frames,
            run=self.run,
            peers=[locator for earlier in self.workers for locator in earlier.locators],
        )
        if uses_zenoh(self.plan, worker.name):
            while not worker.locators and worker.report is None and self._alive(worker):
                self._listen(timeout=0.5)

    def _barrier(self) -> bool:
        """Let all begin at once, when all are ready; False where one failed or the user stopped."""
        while not all(worker.ready for worker in self.workers):
            self._listen(timeout=0.5)
            failed = any(w.report is not None or not self._alive(w) for w in self.workers)
            if failed or self._stop_asked:
                return False
        for worker in self.workers:
            self._tell(worker, "start")
        return True

    def _attend(self, on_progress: OnProgress | None) -> None:
        """Watch the workers until each has reported or died."""
        while any(self._busy(worker) for worker in self.workers):
            self._listen(timeout=PROGRESS_PERIOD)
            if on_progress is not None:
                on_progress(self._progress(), self._expected())
            if self._stop_asked or any(self._failed(worker) for worker in self.workers):
                self._end_early()
            if self._kill_at is not None and time.monotonic() > self._kill_at:
                self._kill_all()

    def _end_early(self) -> None:
        """Ask every worker to finish what is in flight; once."""
        self._stop_asked = False
        if self._kill_at is None:
            self._kill_at = time.monotonic() + _GRACE
            for worker in self.workers:
                self._tell(worker, "stop")

    def _call_off(self) -> None:
        """The run does not start: let every worker close what it set up."""
        for worker in self.workers:
            self._tell(worker, "stop")
        deadline = time.monotonic() + _GRACE
        while any(self._busy(worker) for worker in self.workers) and time.monotonic() < deadline:
            self._listen(timeout=0.2)

    def _listen(self, timeout: float) -> None:
        for key, _ in self._selector.select(timeout):
            worker: WorkerProcess = key.data
            try:
                for message in worker.channel.arrived():
                    self._hear(worker, message)
            except (ChannelClosed, ValueError):
                self._selector.unregister(worker.channel)
                worker.channel.close()

    def _hear(self, worker: WorkerProcess, message: dict[str, Any]) -> None:
        kind = message["kind"]
        if kind == "progress":
            worker.fired, worker.time = message["fired"], message["time"]
        elif kind == "ready":
            worker.ready, worker.expected = True, message["expected"]
        elif kind == "listening":
            worker.locators = message["locators"]
        elif kind == "done":
            worker.report = WorkerReport.from_data(message["report"])
        elif kind == "failed":
            worker.report = WorkerReport(worker.name, 0, error=message["error"])

    def _tell(self, worker: WorkerProcess, kind: str) -> None:
        try:
            worker.channel.send(kind)
        except ChannelClosed:
            return  # its end is noticed where its answers are read

    def _alive(self, worker: WorkerProcess) -> bool:
        return worker.channel.socket.fileno() >= 0

    def _busy(self, worker: WorkerProcess) -> bool:
        return worker.report is None and self._alive(worker)

    def _failed(self, worker: WorkerProcess) -> bool:
        """Whether the worker ended in a way that ends the run."""
        return bool(worker.report.error) if worker.report is not None else not self._alive(worker)

    def _report(self, worker: WorkerProcess) -> WorkerReport:
        if worker.report is not None:
            return worker.report
        if self._alive(worker):  # it neither reported nor ended within its grace
            worker.process.kill()
        return WorkerReport(worker.name, 0, error=worker.obituary())

    def _progress(self) -> Progress:
        """Of the sink that is furthest behind; of the sources where no stage is a sink."""
        senders = {edge.from_stage for edge in self.plan.edges}
        sinks = {stage.worker for stage in self.plan.stages if stage.name not in senders}
        fired = [worker.fired for worker in self.workers if worker.name in sinks]
        return Progress(min(fired, default=0), max((w.time for w in self.workers), default=-1))

    def _expected(self) -> int | None:
        return max((w.expected for w in self.workers if w.expected is not None), default=None)

    def _kill_all(self) -> None:
        """End what still lives; a worker that has reported gets a moment to exit by itself."""
        for worker in self.workers:
            try:
                worker.process.wait(timeout=_PATIENCE if worker.report is not None else 0.0)
            except subprocess.TimeoutExpired:
                worker.process.kill()
                worker.process.wait()
