"""One worker as its host sees it: a process of its own, or a thread of this one."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from followspot.control.dispatch import Request
from followspot.control.host import WorkerPhase, WorkerStatus
from followspot.control.pipe import Channel, ChannelClosed
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.worker_messages import MESSAGES, Done, Failed, Listening, Progress, Ready, Stages
from followspot.control.worker_report import WorkerReport
from followspot.log.record import MAX_TEXT

_TIMEOUT = 5.0
"""Seconds that a worker that has reported may take to exit."""


class Process(Protocol):
    """What a worker runs in, as `subprocess.Popen` has it."""

    @property
    def pid(self) -> int:
        """Number of the process."""

    def poll(self) -> int | None:
        """The exit code; None while the worker lives."""

    def wait(self, timeout: float | None = None) -> int:
        """The exit code, once there is one. Raises subprocess.TimeoutExpired."""

    def kill(self) -> None:
        """End it at once."""


Start = Callable[[str, socket.socket], Process]
"""Starts a worker of this name that speaks on this end of its control channel."""


def start_process(_name: str, end: socket.socket) -> Process:
    """Start a worker in a process of its own. Raises OSError."""
    return subprocess.Popen(
        [sys.executable, "-m", "followspot.worker.main", str(end.fileno())],
        pass_fds=[end.fileno()],
        stdin=subprocess.DEVNULL,
    )


class WorkerProcess:
    """A worker that was started, and what it has told since.

    incarnation: how often the worker had been started before.
    """

    def __init__(self, name: str, incarnation: int, start: Start = start_process) -> None:
        """Start the worker; it waits for its plan. Raises OSError."""
        ours, theirs = socket.socketpair()
        with theirs:
            self.process = start(name, theirs)
        self.name = name
        self.incarnation = incarnation
        self.channel = Channel(ours, MESSAGES, takes_descriptors=False)
        self.open = True
        """Whether the channel still is."""
        self.phase: WorkerPhase = "starting"
        self.fired = 0
        self.time = -1
        self.expected: int | None = None
        self.locators: list[str] = []
        self.report: WorkerReport | None = None
        self.stages: tuple[StageStatus, ...] = ()
        self.paths: tuple[PathStatus, ...] = ()
        self.heard = time.monotonic()
        self.killed = ""
        """Why it was killed from here; "" where it was not."""

    @property
    def busy(self) -> bool:
        """Whether more is to be heard of it."""
        return self.open and self.report is None

    def tell(self, order: Request, descriptors: Sequence[int] = ()) -> None:
        """Send an order; if the worker is gone, that is noticed when its answers are read."""
        try:
            self.channel.send(order, descriptors)
        except ChannelClosed:
            return

    def listen(self) -> list[Request]:
        """What has arrived; call when the channel is readable.

        Closes it where the worker is gone, or says what no worker says: then it is killed, too.
        """
        try:
            messages = [message for message, _ in self.channel.arrived()]
        except ChannelClosed:
            self._hang_up()
            return []
        except ValueError as error:
            self.kill(f"it said what no worker says: {str(error)[:MAX_TEXT]}")
            self._hang_up()
            return []
        self.heard = time.monotonic()
        for message in messages:
            self._hear(message)
        return messages

    def _hang_up(self) -> None:
        self.open = False
        self.channel.close()

    def _hear(self, message: Request) -> None:
        match message:
            case Progress():
                self.fired, self.time = message.fired, message.time
            case Stages():
                self.stages, self.paths = message.stages, message.paths
            case Ready():
                self.phase, self.expected = "ready", message.expected
            case Listening():
                self.locators = list(message.locators)
            case Done():
                self.report = message.report
            case Failed():
                self.report = WorkerReport(self.name, 0, error=message.error)

    def status(self) -> WorkerStatus:
        """As data."""
        return WorkerStatus(
            self.name,
            self.phase,
            self.fired,
            self.time,
            self.expected,
            self.incarnation,
            self.report,
            self.stages,
            self.paths,
            time.monotonic() - self.heard,
        )

    def obituary(self) -> str:
        """How the process ended that did not report."""
        code = self.process.wait()
        how = f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        why = f", because {self.killed}" if self.killed else ""
        return f"worker {self.name} (process {self.process.pid}) died: {how}{why}"

    def kill(self, why: str) -> None:
        """End the process at once, whatever it does. why: a clause for whoever asks how it ended."""
        self.killed = why
        self.process.kill()

    def end(self) -> None:
        """Kill the process unless it has reported and exits by itself."""
        try:
            self.process.wait(timeout=_TIMEOUT if self.report is not None else 0.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.open:
            self._hang_up()
