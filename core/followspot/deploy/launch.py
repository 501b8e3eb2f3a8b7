"""Run a plan on this host: in this thread where it has one worker, else one process a worker."""

from __future__ import annotations

import signal
from types import FrameType
from typing import Protocol

from followspot.deploy.coordinator import Coordinator
from followspot.deploy.host_run import HostRun
from followspot.deploy.local import LocalRun, OnProgress
from followspot.deploy.report import RunReport
from followspot.graph.plan import Plan
from followspot.runtime.wiring import RunOptions


class Run(Protocol):
    """What can be executed, and stopped meanwhile."""

    stopped: bool

    def stop(self) -> None:
        """End the sources; safe in a signal handler."""

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Run to the end."""


def run_plan(plan: Plan, options: RunOptions, on_progress: OnProgress | None = None) -> RunReport:
    """Run on this host to the end of all sources, or until it is interrupted; see `interruptible`."""
    if len(plan.workers) == 1:
        return interruptible(LocalRun(plan, options), on_progress)
    return interruptible(Coordinator(plan, options, [HostRun("")]), on_progress)


def interruptible(run: Run, on_progress: OnProgress | None = None) -> RunReport:
    """Execute; Ctrl-C and SIGTERM end the sources, and outputs are complete either way.

    A second Ctrl-C raises KeyboardInterrupt. Call from the main thread.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        if run.stopped and number == signal.SIGINT:
            raise KeyboardInterrupt
        run.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        return run.execute(on_progress)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
