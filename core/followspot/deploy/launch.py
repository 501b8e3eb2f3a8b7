"""Run a plan: in this thread where it has one worker, else under an agent in this process and others."""

from __future__ import annotations

import signal
from pathlib import Path
from types import FrameType
from typing import Protocol

from followspot.deploy.coordinator import Coordinator, order_of
from followspot.deploy.host_run import HostRun
from followspot.deploy.log.run_log import OnLog
from followspot.deploy.progress import OnProgress
from followspot.deploy.reachable import reachable
from followspot.deploy.report import RunReport
from followspot.deploy.run_requests import Surroundings, run_dispatcher
from followspot.graph.plan import Plan
from followspot.runtime.wiring import RunOptions
from followspot.transport.zenoh_network import Network


class Run(Protocol):
    """What can be executed, and stopped meanwhile."""

    stopped: bool

    def stop(self) -> None:
        """End the sources; safe in a signal handler."""

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Run to the end."""


def run_plan(
    plan: Plan,
    options: RunOptions,
    on_progress: OnProgress | None = None,
    *,
    network: Network = Network(),
    media: Path = Path(),
    restart: bool = False,
    on_log: OnLog | None = None,
) -> RunReport:
    """Run to the end of all sources, or until it is interrupted; see `interruptible`.

    network: leads to the agents of other hosts that the plan names; media: folder here whose files agents
    have below their own --media folder; restart: whether workers that die are started again in a replay,
    too, as they are in live runs; on_log: gets each record of the log. Raises InputError where an agent is
    missing.
    """
    order = order_of(plan, options, restart=restart or any(stage.live for stage in plan.stages))
    if network.public or any(worker.host for worker in plan.workers):
        from followspot.deploy.reach import reached

        with reached(plan, network, media) as (hosts, others):
            around = Surroundings(options.out.resolve(), network.for_worker(network.connect))
            return _reachable(Coordinator(plan, hosts, order, on_log, others), on_progress, around)
    return _reachable(
        local_run(plan, options, on_log, restart=order.restart),
        on_progress,
        Surroundings(options.out.resolve()),
    )


def local_run(
    plan: Plan, options: RunOptions, on_log: OnLog | None = None, *, restart: bool = False
) -> Coordinator:
    """A run on this host alone: one worker is a thread of this process, several are processes."""
    if len(plan.workers) > 1:
        return Coordinator(plan, [HostRun("")], order_of(plan, options, restart=restart), on_log)
    from followspot.deploy.worker_thread import WorkerThread

    host = HostRun("", start=WorkerThread)
    return Coordinator(plan, [host], order_of(plan, options, restart=False), on_log)


def _reachable(run: Coordinator, on_progress: OnProgress | None, surroundings: Surroundings) -> RunReport:
    """Execute; meanwhile other processes of the user can find the run, look at it and change it."""
    with reachable(run.name, run.plan.graph, run_dispatcher(run, surroundings)):
        return interruptible(run, on_progress)


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
