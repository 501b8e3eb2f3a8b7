"""Run a plan: in this process where it has one worker, else one process a worker."""

from __future__ import annotations

import signal
from types import FrameType

from followspot.deploy.launcher import ProcessRun
from followspot.deploy.local import LocalRun, OnProgress
from followspot.deploy.report import RunReport
from followspot.graph.plan import Plan
from followspot.runtime.wiring import RunOptions


def run_plan(plan: Plan, options: RunOptions, on_progress: OnProgress | None = None) -> RunReport:
    """Run to the end of all sources, or until Ctrl-C or SIGTERM ends them; outputs are complete either way.

    A second Ctrl-C raises KeyboardInterrupt. Call from the main thread.
    """
    run = LocalRun(plan, options) if len(plan.workers) == 1 else ProcessRun(plan, options)

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
