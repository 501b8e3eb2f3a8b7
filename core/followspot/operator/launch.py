"""Starts a run of a plan: its workers are threads or processes of this host, or belong to remote agents."""

from __future__ import annotations

import signal
import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Protocol

from followspot.control.progress import OnProgress
from followspot.control.unix_socket import serve_requests
from followspot.graph.plan import Plan
from followspot.host.local_host import LocalHost
from followspot.log.run_log import OnLog
from followspot.operating_system.ending_signals import ending_signals
from followspot.operator.coordinator import Coordinator
from followspot.operator.new_order import new_order
from followspot.operator.output_folder import reserved_folder
from followspot.operator.reporting.report import RunReport
from followspot.operator.run_dispatcher import run_dispatcher
from followspot.operator.run_requests import RunMetadata
from followspot.transport.zenoh.network import Network
from followspot.worker.wiring import RunOptions


class Run(Protocol):
    """A run that `interruptible` can execute and stop."""

    stopped: bool

    def stop(self) -> None:
        """End the sources. Safe in a signal handler."""

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Block until the run ends; return its report."""


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
    """Run until all sources end or the user interrupts; see `interruptible`.

    network: leads to the agents of the other hosts that the plan names; media: local folder whose files
    agents have below their own --media folder; restart: whether workers that die are restarted in a replay
    too, as they are in live runs; on_log: gets each log record. Raises InputError if an agent is missing.
    """
    ready = prepared_run(plan, options, network=network, media=media, restart=restart, on_log=on_log)
    with ready as (run, metadata):
        return _run_served(run, on_progress, metadata)


@contextmanager
def prepared_run(
    plan: Plan,
    options: RunOptions,
    *,
    network: Network = Network(),
    media: Path = Path(),
    restart: bool = False,
    on_log: OnLog | None = None,
    in_process: Collection[str] = (),
) -> Iterator[tuple[Coordinator, RunMetadata]]:
    """A run that has not begun, and its metadata; see `run_plan`.

    in_process: workers of this host that run as threads of this process; a plan's only worker always does.
    Raises InputError if an agent is missing, FollowspotError if another run writes to the output folder, or
    if an endpoint is none, although the plan may need no agent.
    """
    network.check_endpoints()
    restart = restart or plan.live
    with reserved_folder(options.out):
        if network.public or any(worker.host for worker in plan.workers):
            from followspot.operator.discovery import discovered_hosts

            order = new_order(plan, options, restart=restart)
            with discovered_hosts(plan, network, media, in_process) as (hosts, others):
                near = network.for_worker(network.connect)
                metadata = RunMetadata(options.out.resolve(), near, plan.source_files, time.time())
                yield Coordinator(plan, hosts, order, on_log, others), metadata
                return
        run = local_run(plan, options, on_log, restart=restart, in_process=in_process)
        yield run, RunMetadata(options.out.resolve(), None, plan.source_files, time.time())


def unused_agents(plan: Plan, endpoints: Sequence[str]) -> tuple[str, ...]:
    """A note if the user names endpoints of agents but the plan uses no other host; empty otherwise."""
    if not endpoints or any(worker.host for worker in plan.workers):
        return ()
    return (
        f"no worker is on another host, so agents at {', '.join(endpoints)} have nothing to do: "
        "name hosts in a file for --placement, or move stages there while the run goes on",
    )


def local_run(
    plan: Plan,
    options: RunOptions,
    on_log: OnLog | None = None,
    *,
    restart: bool = False,
    in_process: Collection[str] = (),
) -> Coordinator:
    """A run on this host alone; see `prepared_run`."""
    if len(plan.workers) == 1:  # a thread that hangs cannot be killed and replaced
        in_process, restart = (plan.workers[0].name,), False
    host = LocalHost("", in_process=in_process)
    return Coordinator(plan, [host], new_order(plan, options, restart=restart), on_log)


def _run_served(run: Coordinator, on_progress: OnProgress | None, metadata: RunMetadata) -> RunReport:
    """Execute the run; meanwhile other processes of the user can find, watch and change it."""
    with serve_requests(run.name, run.plan.graph, run_dispatcher(run, metadata)):
        return interruptible(run, on_progress)


def interruptible(run: Run, on_progress: OnProgress | None = None) -> RunReport:
    """Execute the run; on Ctrl-C, SIGTERM or when the terminal closes its sources end, and its outputs are
    still complete. `nohup` keeps it running.

    A second Ctrl-C raises KeyboardInterrupt. Call this from the main thread.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        if run.stopped and number == signal.SIGINT:
            raise KeyboardInterrupt
        run.stop()

    before = {number: signal.signal(number, stop) for number in ending_signals()}
    try:
        return run.execute(on_progress)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
