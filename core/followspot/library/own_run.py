"""A run that a script or a notebook has started in its own process."""

from __future__ import annotations

import atexit
import os
import threading
import time
import warnings
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Any

from followspot.control.dispatch import Dispatcher, Request
from followspot.control.lifecycle import StopRun
from followspot.control.unix_socket import serve_requests
from followspot.errors import FollowspotError
from followspot.library.flight_recorder import StartRecorder, no_recorder
from followspot.library.keywords import errors_in_python, in_python
from followspot.library.report import Report
from followspot.library.script_handle import ScriptHandle
from followspot.library.subscription import Subscription
from followspot.library.subscription_sinks import SubscriptionSinks
from followspot.operator.change_outcome import ChangeOutcome
from followspot.operator.coordinator import Coordinator
from followspot.operator.reporting.report import RunReport
from followspot.operator.reporting.truth import run_scores
from followspot.operator.run_dispatcher import run_dispatcher
from followspot.operator.run_requests import RunMetadata
from followspot.plugins.registry import offer_stage
from followspot.scoring import Score
from followspot.stage import Stage

_POLL_INTERVAL = 1.0
"""Seconds between two checks whether the run waits for a subscription without a reader."""
_BEGIN = 120.0
"""Seconds that stages may take to be set up before a run answers."""

_RECORDER_POLL_INTERVAL = 0.05
"""Seconds between two checks whether the flight recorder is ready."""

PreparedRun = tuple[Coordinator, RunMetadata]


class RunFailed(FollowspotError):
    """The run ended with errors; the text has them."""


class OwnRun(ScriptHandle):
    """A run of this process. Its thread goes on until the sources end, `stop`, or the end of the block."""

    def __init__(
        self,
        sinks: SubscriptionSinks,
        prepared: AbstractContextManager[PreparedRun],
        out: Path,
        recorder: StartRecorder,
    ) -> None:
        """Begin the run. sinks: those of its plan; out: folder for its outputs."""
        super().__init__("", sinks.plan.graph, self._asked, failure=self._failure)
        self.out = out
        self._sinks = sinks
        self._dispatcher: Dispatcher | None = None
        self._report: RunReport | None = None
        self._whole: Report | None = None
        self._error: BaseException | None = None
        self._begun = threading.Event()
        self._ended = threading.Event()
        """Not the thread's own end: `Thread.join` takes a thread for ended when Ctrl-C interrupts it."""
        sinks.failure = self._failure
        self._abandoned = False
        self._pid = os.getpid()
        atexit.register(self._end_at_exit)
        threading.Thread(target=self._run, args=(prepared, recorder), name="run", daemon=True).start()
        try:
            self._begun.wait(_BEGIN)
            if recorder is not no_recorder:
                self._await_recorder()
        except BaseException:  # after Ctrl-C no script has this handle, and so none could end the run
            self._abandon()
            raise

    def close(self) -> None:
        """End the run, and wait until its outputs are complete."""
        self._sinks.close()
        super().close()
        if not self._ended.is_set() and self._dispatcher is not None:
            self.stop()
        self._ended.wait()

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close()
        if kind is None:
            self._raise()
            self._warn()

    def swap(self, stage: str, uses: str | type[Stage], *, fresh: bool = False) -> ChangeOutcome:
        """Replace a stage during the run by another plugin stage, or by a class of this process."""
        return super().swap(stage, uses if isinstance(uses, str) else offer_stage(uses), fresh=fresh)

    def __getitem__(self, port: str) -> Subscription[Any]:
        """The messages of a port: all of them if it was named in `ports=`, else the newest from now on.

        port: STAGE.PORT, or a shorter name as `ports=` takes it. Raises FollowspotError.
        """
        found = self._sinks.found(port)
        if found is not None and (self._ended.is_set() or not found.closed):
            return found
        return super().__getitem__(port)

    def wait(self) -> Report:
        """Wait for the end of the run and return its report.

        Raises RunFailed if it failed, FollowspotError if it waits for a subscription without a reader.
        """
        while not self._ended.wait(_POLL_INTERVAL):
            self._sinks.check_read()
        self._raise()
        return self.report

    @property
    def report(self) -> Report:
        """The report of the run, with a warning if its files cannot be scored.

        Raises FollowspotError before its end, RunFailed if it never began.
        """
        if self._whole is not None:
            return self._whole
        if not self._ended.is_set():
            raise FollowspotError("the run goes on; leave its block, or wait() for its end")
        if self._report is None:
            raise RunFailed(str(self._error)) from self._error
        scores: dict[str, Score] = {}
        try:
            scores = run_scores(self._sinks.plan, self.out, self._report.frames)
        except FollowspotError as error:
            warnings.warn(f"cannot score the run: {error}", stacklevel=2)
        self._whole = Report(self._report, self.out, scores)
        return self._whole

    def _await_recorder(self) -> None:
        """Wait until the flight recorder has begun to hold messages."""
        deadline = time.monotonic() + _BEGIN
        with suppress(FollowspotError):  # the run has ended
            while self.kept() is None and time.monotonic() < deadline:
                time.sleep(_RECORDER_POLL_INTERVAL)

    def _abandon(self) -> None:
        """Have the run end as soon as its stages are set up, without waiting for that."""
        self._abandoned = True
        self._sinks.close()
        if self._dispatcher is not None:
            self.stop()

    def _end_at_exit(self) -> None:
        """End a run that goes on when the script has ended; its outputs would be cut off anywhere."""
        if os.getpid() != self._pid:  # a copy of the process, without the thread of the run
            return
        remedy = 'use it in a "with" block, or wait() for its end'
        told = f"{self.label} goes on at the end of the script, and is stopped: {remedy}"
        try:
            warnings.warn(told, stacklevel=1)
        finally:  # warnings may be errors
            self.close()

    def _run(self, prepared: AbstractContextManager[PreparedRun], recorder: StartRecorder) -> None:
        """Prepare and execute the run, in a thread; then wake all that wait for its end."""
        try:
            with errors_in_python(), prepared as (coordinator, metadata):
                self.run = coordinator.name
                self._dispatcher = run_dispatcher(coordinator, metadata)
                if self._abandoned:
                    coordinator.stop()
                with (
                    recorder(self.run) as take_errors,
                    serve_requests(self.run, self.graph, self._dispatcher),
                ):
                    self._report = coordinator.execute(on_begin=self._begun.set)
                    take_errors(self._report.errors)
        except BaseException as error:
            self._error = error
        finally:
            self._begun.set()
            self._sinks.end()
            self._taps.end()
            self._ended.set()
            atexit.unregister(self._end_at_exit)

    def _asked(self, request: Request, timeout: float) -> Any:
        if self._dispatcher is None or self._ended.is_set():
            if isinstance(request, StopRun):
                return None  # it may have ended a moment ago
            raise FollowspotError("the run has ended")
        with errors_in_python(), self._sinks.yielding():  # the loop over a subscription may be what asks
            return self._dispatcher.dispatch(request)

    def _failure(self) -> Exception | None:
        """The error of the run after its end; None if it succeeded."""
        self._ended.wait()
        if isinstance(self._error, FollowspotError):
            return self._error
        if self._error is not None:
            return RunFailed(repr(self._error))
        errors = self._report.errors if self._report is not None else ()
        return RunFailed(in_python("\n".join(errors))) if errors else None

    def _warn(self) -> None:
        """Issue the report's warnings in Python and, unless the run was stopped, name the silent stages."""
        report = self._report
        if report is None:
            return
        silences = () if report.stopped else report.silences
        for text in (*report.warnings, *(f"{silence}; {silence.advice}" for silence in silences)):
            warnings.warn(in_python(text), stacklevel=3)

    def _raise(self) -> None:
        if (error := self._failure()) is not None:
            raise error
