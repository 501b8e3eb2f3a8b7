"""A host's side of one worker: its process or thread, its control channel, its newest status."""

from __future__ import annotations

import signal
import socket
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from types import MappingProxyType
from typing import Protocol

from followspot.control.dispatch import Dispatcher, Handlers
from followspot.control.host import WorkerPhase, WorkerStatus
from followspot.control.pipe import Channel, ChannelClosed
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.worker_messages import (
    Built,
    Done,
    Failed,
    Listening,
    Progress,
    Ready,
    Stages,
)
from followspot.control.worker_report import WorkerReport
from followspot.host.forked_worker import EXIT_CODE_UNKNOWN
from followspot.log.record import MAX_TEXT

_NO_SERVER = "the process that forks workers died or was suspended"
_TIMEOUT = 5.0
"""Seconds that a worker has to exit after its report."""
_KILL_TIMEOUT = 2.0
"""Seconds that a worker has to exit after it was killed: a thread whose stage never returns does not."""


class Process(Protocol):
    """The process or thread of a worker, with the interface of `subprocess.Popen`."""

    @property
    def pid(self) -> int:
        """Process id."""

    def poll(self) -> int | None:
        """The exit code; None while the worker is alive."""

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the exit and return its code. Raises subprocess.TimeoutExpired."""

    def kill(self) -> None:
        """End the worker at once."""


Start = Callable[[str, socket.socket], Process]
"""Starts the worker of this name; the socket is its end of the control channel."""


class WorkerProcess:
    """A started worker and the newest figures that it has sent.

    incarnation: number of earlier starts of this worker.
    """

    def __init__(
        self,
        name: str,
        incarnation: int,
        start: Start,
        handlers: Handlers = MappingProxyType({}),
        fired_before: int = 0,
    ) -> None:
        """Start the worker, which waits for its plan. Raises OSError.

        handlers: of further messages; fired_before: frames done by its earlier incarnations.
        """
        ours, theirs = socket.socketpair()
        with theirs:
            self.process = start(name, theirs)
        self.name = name
        self.incarnation = incarnation
        self._dispatcher = Dispatcher("host", {**self._handlers(), **handlers})
        self.channel = Channel(ours, self._dispatcher.kinds, takes_descriptors=False)
        self.open = True
        """True while the control channel is open."""
        self.phase: WorkerPhase = "starting"
        self.fired = 0
        """Frames done by this incarnation."""
        self._fired_before = fired_before
        self.time = -1
        self.expected: int | None = None
        self.last_times: dict[str, int] = {}
        self.locators: list[str] = []
        self.report: WorkerReport | None = None
        self.stages: tuple[StageStatus, ...] = ()
        self.paths: tuple[PathStatus, ...] = ()
        self.stages_told: float | None = None
        """Monotonic time of the newest statuses of stages, s."""
        self.heard = time.monotonic()
        self.killed = ""
        """Why the host killed the worker, "" if it did not."""

    @property
    def busy(self) -> bool:
        """True while the worker can still send messages."""
        return self.open and self.report is None

    def begin(self) -> None:
        """Set the phase to running.

        The silence is counted from now, because the worker sent nothing while it waited for the others.
        """
        self.phase, self.heard = "running", time.monotonic()

    def receive(self) -> None:
        """Take the messages that have arrived; call this when the channel is readable.

        Closes the channel if the worker has exited. Kills the worker as well if it sent an invalid message.
        """
        try:
            messages = self.channel.arrived()
        except ChannelClosed:
            self._close_channel()
            return
        except ValueError as error:
            self.kill(f"it sent an invalid message: {str(error)[:MAX_TEXT]}")
            self._close_channel()
            return
        self.heard = time.monotonic()
        for message, _ in messages:
            self._dispatcher.dispatch(message)

    def _close_channel(self) -> None:
        self.open = False
        self.channel.close()

    def _handlers(self) -> Handlers:
        """The messages that concern this worker alone."""
        return {
            Built: lambda _: None,
            Listening: self._listening,
            Ready: self._ready,
            Progress: self._progress,
            Stages: self._stages,
            Done: self._done,
            Failed: self._failed,
        }

    def _listening(self, message: Listening) -> None:
        self.locators = list(message.locators)

    def _ready(self, message: Ready) -> None:
        self.phase, self.expected, self.last_times = "ready", message.expected, message.last_times

    def _progress(self, message: Progress) -> None:
        self.fired, self.time = message.fired, message.time

    def _stages(self, message: Stages) -> None:
        self.stages, self.paths, self.stages_told = message.stages, message.paths, time.monotonic()

    def _done(self, message: Done) -> None:
        self.report = message.report

    def _failed(self, message: Failed) -> None:
        self.report = WorkerReport(self.name, 0, error=message.error)

    def status(self) -> WorkerStatus:
        """The newest status of the worker."""
        return WorkerStatus(
            name=self.name,
            phase=self.phase,
            fired=self._fired_before + self.fired,
            time=self.time,
            expected=self.expected,
            restarts=self.incarnation,
            report=self.report,
            stages=self.stages,
            paths=self.paths,
            age_s=time.monotonic() - self.heard,
            stages_age_s=None if self.stages_told is None else time.monotonic() - self.stages_told,
            last_times=self.last_times,
        )

    def at_work(self) -> str:
        """A clause with the stages that were at work by the newest statuses, "" if none was."""
        names = [status.stage for status in self.stages if status.state == "processing"]
        return f", in which stage {' and '.join(names)} was at work" if names else ""

    def exit_reason(self) -> str:
        """How a process that sent no report ended, or that it goes on although it was killed."""
        why = f", because {self.killed}" if self.killed else ""
        try:
            code, pid = self.process.wait(timeout=_KILL_TIMEOUT), self.process.pid
        except subprocess.TimeoutExpired:
            return f"worker {self.name} was given up{why}: a stage does not return"
        if not pid:
            return f"worker {self.name} was not started: {_NO_SERVER}{why}"
        how = f"exit code unknown, as {_NO_SERVER}" if code == EXIT_CODE_UNKNOWN else f"exit code {code}"
        how = f"killed by {signal.Signals(-code).name}" if code < 0 else how
        return f"worker {self.name} (process {pid}) died: {how}{why}"

    def kill(self, why: str) -> None:
        """End the process at once. why: the reason as a clause, for `exit_reason`."""
        self.killed = why
        self.process.kill()

    def end(self) -> None:
        """Wait for the exit of a worker that has reported; kill any other. Close the channel."""
        try:
            self.process.wait(timeout=_TIMEOUT if self.report is not None else 0.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(timeout=_KILL_TIMEOUT)
        if self.open:
            self._close_channel()
