"""A plan with one worker runs in this very process: no start-up cost, and a debugger sees every stage."""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path

from followspot.deploy.changes.changed import Changed, Moved, changed, with_change
from followspot.deploy.host import WorkerStatus
from followspot.deploy.links import EdgeLinks, ring_edges, socket_pair, uses_zenoh
from followspot.deploy.log.collector import LogCollector, collecting
from followspot.deploy.log.record import LogPage
from followspot.deploy.log.run_log import OnLog, RunLog
from followspot.deploy.report import RunReport, Warnings, merge, worker_report
from followspot.deploy.status import RunStatus
from followspot.errors import FollowspotError
from followspot.graph.change import changed_stages
from followspot.graph.move import moved
from followspot.graph.plan import Plan
from followspot.runtime.building import build_worker
from followspot.runtime.ledger import Ledger
from followspot.runtime.stage_status import paths_now, stages_now
from followspot.runtime.succession import Successor, given_up, prepared, take_over
from followspot.runtime.tapping import Tapping, close_taps, tap
from followspot.runtime.wiring import RunOptions, Wiring
from followspot.runtime.worker import Progress

OnProgress = Callable[[Progress, int | None], None]
"""Called a few times a second with the progress and the expected number of frames."""
PROGRESS_PERIOD = 0.2
"""Seconds between two reports of progress."""
_GLANCE = 0.01
"""Seconds between two looks whether a change was made."""


class LocalRun:
    """A run of a one-worker plan in the calling thread."""

    def __init__(self, plan: Plan, options: RunOptions, on_log: OnLog | None = None) -> None:
        """Builds every stage. Raises StageError where one cannot be built."""
        self.plan = plan
        self.log = RunLog(on_log)
        self._collector = LogCollector(plan.workers[0].name)
        self.warnings = Warnings(lambda stage, text: self._collector.say("warning", stage, text))
        self.ledger = Ledger(len(plan.edges))
        self.stopped = False
        self.name = uuid.uuid4().hex
        self._over = threading.Event()
        self._one_change = threading.Lock()
        self.links = _links(plan, self.name)
        options = RunOptions(options.out, options.frames, self.warnings.add)
        name = plan.workers[0].name
        self.worker = build_worker(Wiring(plan), name, self.ledger, options, self.links)

    def change(self, words: Sequence[str], folder: Path, *, fresh: bool = False) -> Changed:
        """Swap stages and set parameters while the run goes on; see `Coordinator.change`."""
        with self._one_change:
            stages = changed_stages(self.plan, words, folder)
            report = changed(self.name, self.plan, stages)
            successors = prepared(self.worker, stages)
            done: Future[None] = Future()
            self.worker.between_firings(lambda: self._take_over(successors, fresh, done))
            while not done.done() and not self._over.wait(_GLANCE):
                pass
            if done.cancel() or done.cancelled():
                given_up(successors)
                raise FollowspotError("the run has ended")
            done.result()
            self.plan = with_change(self.plan, stages)
            return report

    def move(self, names: Sequence[str], place: str) -> Moved:
        """There is no other place. Raises InputError, FollowspotError."""
        found = Moved.of(self.name, self.plan, moved(self.plan, names, place))
        if found.stages:
            raise FollowspotError("this run has one worker")
        return found

    def _take_over(self, successors: Sequence[Successor], fresh: bool, done: Future[None]) -> None:
        """In the worker's thread, between two firings."""
        if not done.set_running_or_notify_cancel():
            return
        try:
            take_over(self.worker, successors, fresh=fresh)
        except Exception as error:
            done.set_exception(error)
        else:
            done.set_result(None)

    def stop(self) -> None:
        """End the sources; what is in flight is finished. Safe in a signal handler."""
        self.stopped = True
        self.worker.stop()

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Run to the end; errors of stages stand in the report."""
        with collecting(self._collector):
            return self._execute(on_progress)

    def _execute(self, on_progress: OnProgress | None) -> RunReport:
        started = time.monotonic()
        error = ""
        try:
            self.links.wait_matched()
            self.worker.setup()
            started = time.monotonic()
            with _Ticker(lambda: self._tick(on_progress)):
                self.worker.run()
        except FollowspotError as failure:
            error = str(failure)
        finally:
            self._over.set()
            close_taps(self.worker)
            self.worker.close()
            self.links.close()
        seconds = time.monotonic() - started
        report = worker_report(self.plan.workers[0].name, self.worker, self.warnings, error)
        self._tick(on_progress)
        if error:
            self.log.say("error", error, worker=report.worker)
        return merge(self.plan, self.ledger, [report], seconds, stopped=self.stopped)

    def status(self) -> RunStatus:
        """The run at this moment; safe from any thread."""
        progress, expected = self.worker.progress(), self.worker.expected()
        worker = WorkerStatus(
            self.plan.workers[0].name,
            "running",
            progress.fired,
            progress.time,
            expected,
            stages=stages_now(self.worker, self.warnings.last),
            paths=paths_now(self.worker),
        )
        return RunStatus((worker,), tuple(self.ledger.words.tolist()), progress.fired, expected)

    def tap(self, tappings: Sequence[Tapping]) -> None:
        """Look at ports; safe from any thread. Raises what a sink raises."""
        tap(self.worker, tappings)

    def records(self, after: int) -> LogPage:
        """What was logged after the record of this number; safe from any thread."""
        return self.log.after(after)

    def _tick(self, on_progress: OnProgress | None) -> None:
        self.log.add(*self._collector.take())
        if on_progress is not None:
            on_progress(self.worker.progress(), self.worker.expected())


class _Ticker:
    """Calls a function every `PROGRESS_PERIOD` from a thread of its own, while the block runs."""

    def __init__(self, tick: Callable[[], None]) -> None:
        self._tick = tick
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="progress", daemon=True)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._over.wait(PROGRESS_PERIOD):
            self._tick()


def _links(plan: Plan, run: str) -> EdgeLinks:
    """Edge ends within this process, for edges that were forced away from the plain call."""
    pairs = {number: socket_pair() for number in ring_edges(plan)}
    session = None
    if uses_zenoh(plan):
        from followspot.transport.zenoh_session import open_session

        session = open_session()
    sending = {number: pair[0] for number, pair in pairs.items()}
    receiving = {number: pair[1] for number, pair in pairs.items()}
    return EdgeLinks(plan, sending, receiving, session, run)
