"""Run a plan: in this thread where it has one worker, else under an agent in this process and others."""

from __future__ import annotations

import signal
import socket
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Protocol

from followspot.graph.plan import Plan
from followspot.host.local_host import LocalHost
from followspot.host.worker_process import Process, start_process
from followspot.log.run_log import OnLog
from followspot.operator.control_socket import reachable
from followspot.operator.coordinator import Coordinator, order_of
from followspot.operator.progress import OnProgress
from followspot.operator.report import RunReport
from followspot.operator.run_requests import Surroundings, run_dispatcher
from followspot.transport.zenoh.network import Network
from followspot.worker.wiring import RunOptions


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
    ready = prepared(plan, options, network=network, media=media, restart=restart, on_log=on_log)
    with ready as (run, around):
        return _reachable(run, on_progress, around)


@contextmanager
def prepared(
    plan: Plan,
    options: RunOptions,
    *,
    network: Network = Network(),
    media: Path = Path(),
    restart: bool = False,
    on_log: OnLog | None = None,
    in_process: Collection[str] = (),
) -> Iterator[tuple[Coordinator, Surroundings]]:
    """A run that has not begun, and what is around it; see `run_plan`.

    in_process: workers of this host that are threads of this process; a plan's only worker always is.
    Raises InputError where an agent is missing.
    """
    restart = restart or plan.live
    if network.public or any(worker.host for worker in plan.workers):
        from followspot.operator.discovery import reached

        start = partial(_started, in_process)
        order = order_of(plan, options, restart=restart)
        with reached(plan, network, media, start) as (hosts, others):
            around = Surroundings(options.out.resolve(), network.for_worker(network.connect))
            yield Coordinator(plan, hosts, order, on_log, others), around
            return
    run = local_run(plan, options, on_log, restart=restart, in_process=in_process)
    yield run, Surroundings(options.out.resolve())


def local_run(
    plan: Plan,
    options: RunOptions,
    on_log: OnLog | None = None,
    *,
    restart: bool = False,
    in_process: Collection[str] = (),
) -> Coordinator:
    """A run on this host alone; see `prepared`."""
    if len(plan.workers) == 1:  # a thread cannot be started again in place of one that hangs
        in_process, restart = (plan.workers[0].name,), False
    host = LocalHost("", start=partial(_started, in_process))
    return Coordinator(plan, [host], order_of(plan, options, restart=restart), on_log)


def _started(in_process: Collection[str], name: str, end: socket.socket) -> Process:
    """A worker of this host: a thread of this process, or a process of its own. Raises OSError."""
    if name not in in_process:
        return start_process(name, end)
    from followspot.host.worker_thread import WorkerThread

    return WorkerThread(name, end)


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
