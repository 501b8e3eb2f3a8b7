"""The agent: a process on a host that starts and supervises workers there and answers operators."""

from __future__ import annotations

import re
import select
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from followspot.control.dispatch import Dispatcher, RunRequest
from followspot.control.host import RunOrder
from followspot.control.lifecycle import (
    CloseRun,
    EndWorkers,
    FindRun,
    GetOrder,
    ListRuns,
    PrepareRun,
    StartRun,
    StopRun,
)
from followspot.control.move import MoveOrder
from followspot.control.observation import ClockReading, GetHostStatus, GetLog, GetStates, ReadClock
from followspot.control.relay import Relayed
from followspot.control.swap import ChangeOrder
from followspot.control.worker_orders import RELAYED
from followspot.control.zenoh_rpc import RpcClient, RpcServer, agents
from followspot.errors import FollowspotError
from followspot.graph.plan_data import plan_from_data
from followspot.host.agent_changes import AgentChanges
from followspot.host.agent_options import AgentOptions
from followspot.host.agent_run import AgentRun
from followspot.host.agent_runs import AgentRuns
from followspot.host.clocks.host import HostClock
from followspot.host.local_host import LocalHost
from followspot.log.file import LogFile
from followspot.operating_system.limits import limit_remedy
from followspot.plugins.code_digest import other_code
from followspot.plugins.registry import use_plugin_files
from followspot.transport import wire
from followspot.transport.host_registry import expiring_soon
from followspot.transport.wakeup_event import WakeupEvent
from followspot.transport.zenoh.connections import Connections
from followspot.transport.zenoh.session import close_session, connected_in_the_end, locators
from followspot.valid_values.names import HOST_NAME

_POLL_MS = 100
"""Longest wait between two polls of the workers, ms."""
_RUN = re.compile(r"[0-9a-f]{8,64}")
"""Valid names of runs."""


class Agent:
    """Serves requests until it is stopped. One thread does all work; Zenoh's threads only wake it."""

    def __init__(self, options: AgentOptions, log_line: Callable[[str], None] = lambda line: None) -> None:
        """log_line: gets lines for the log. Raises FollowspotError if the name or an endpoint is wrong."""
        if HOST_NAME.fullmatch(options.name) is None:
            raise FollowspotError(
                f"{options.name!r} cannot be the name of a host; use letters, digits, - _ ."
            )
        own = options.network.own
        if options.network.certificates and own.name != options.name:
            raise FollowspotError(
                f"the certificate is that of {own.name}; name this agent so, or use that of {options.name}"
            )
        use_plugin_files(options.plugin_files)
        self.options = options
        self.log_line = log_line
        self.agent_runs = AgentRuns(options.runs, options.name, log_line)
        self._changes = AgentChanges(options, self.agent_runs, log_line)
        self._wakeup = WakeupEvent()
        self._stopping = False
        self.session = connected_in_the_end(options.network, log_line)
        self.locators = locators(self.session)

    def stop(self) -> None:
        """End all runs and make `serve` return. Safe in a signal handler."""
        self._stopping = True
        self._wakeup.set()

    def serve(self) -> None:
        """Answer requests and supervise workers until `stop`; then end every worker.

        Raises FollowspotError if there is an agent of this name already.
        """
        try:
            if self.options.name in agents(self.session, timeout=0.5):
                raise FollowspotError(f"there is an agent {self.options.name} already")
            self._resume_detached()
            server = RpcServer(
                self.session, self.options.name, self._dispatcher(), self._wakeup.set, self.log_line
            )
            try:
                with Connections(self.session, self.options.network, self.log_line):
                    self._loop(server)
            finally:
                server.close()
            self.agent_runs.forget()
        finally:
            for agent_run in self.agent_runs:
                agent_run.run.close()
            self._wakeup.close()
            close_session(self.session)

    def _resume_detached(self) -> None:
        """Resume the detached runs of an earlier agent of this name that died."""
        for order in self.agent_runs.kept.left():
            self.log_line(f"run {order.run[:8]}: resumed")
            try:
                self.prepare(order)
                line = "the agent was restarted: its workers start again"
                self.agent_runs.agent_run(order.run).run.report_event("warning", line)
                self.start(order.run)
            except (FollowspotError, ValueError, OSError) as error:
                self.log_line(f"run {order.run[:8]}: cannot be resumed: {error}")

    def _loop(self, server: RpcServer) -> None:
        """Answer requests and supervise workers until `stop` and the end of all runs."""
        while not (self._stopping and all(agent_run.over for agent_run in self.agent_runs)):
            poll = select.poll()
            for fd in (self._wakeup.fileno(), *(agent_run.run.fileno() for agent_run in self.agent_runs)):
                poll.register(fd, select.POLLIN)
            poll.poll(_POLL_MS)
            self._wakeup.clear()
            server.answer()
            for agent_run in self.agent_runs:
                agent_run.run.attend(0)
                if self._stopping:
                    agent_run.end(time.monotonic())
            self.agent_runs.tidy(time.monotonic())

    def _dispatcher(self) -> Dispatcher:
        """The handlers of requests to this agent."""
        runs = self.agent_runs
        return Dispatcher(
            "host",
            {
                PrepareRun: lambda request: self.prepare(request.order),
                StartRun: lambda request: self.start(request.run),
                **dict.fromkeys((StopRun, EndWorkers, GetHostStatus, GetStates, GetLog), self._ask),
                ChangeOrder: self._changes.change,
                MoveOrder: self._changes.move,
                **dict.fromkeys(RELAYED, self.relay),
                ReadClock: lambda request: self._read_clock(request.run),
                CloseRun: lambda request: runs.close(request.run),
                FindRun: lambda request: runs.known(request.run),
                ListRuns: lambda _: runs.listing(),
                GetOrder: lambda request: runs.agent_run(request.run).order,
            },
        )

    def _read_clock(self, run: str) -> ClockReading:
        """The clocks of this host; for a run that goes on here as if the wall clock had not been set."""
        clocks = (found.run.clock for found in self.agent_runs if found.order.run == run)
        return next(clocks, HostClock(known=self.options.clock_offset)).read()

    def _ask(self, request: RunRequest) -> Any:
        """The answer of the run that the request names. Raises FollowspotError if there is none."""
        return self.agent_runs.agent_run(request.run).run.ask(request)

    def prepare(self, order: RunOrder) -> None:
        """Start the workers of a run. Raises FollowspotError if the agent refuses it, ValueError, OSError."""
        name = self.options.name
        if self._stopping:
            raise FollowspotError(f"the agent {name} is ending")
        if not _RUN.fullmatch(order.run):
            raise FollowspotError(f"{order.run[:80]!r} cannot be the name of a run")
        if order.wire_version != wire.VERSION:
            formats = f"the run sends messages of format {order.wire_version}, this host reads {wire.VERSION}"
            raise FollowspotError(f"{formats}: install the same version of followspot on both hosts")
        self.agent_runs.check_capacity(order.run)
        plan = self.options.unpacked(order.plan)
        planned = plan_from_data(plan)
        graph = planned.graph
        other = other_code(order.code, (stage.uses for stage in planned.stages_on(name)))
        out = self._folder(order.run)
        hub = (*self.locators, *self.options.network.connect)
        clock = HostClock(RpcClient(self.session, self.options.network.own), self.options.clock_offset)
        run = LocalHost(name, self.options.network, hub, clock)
        run.log.on_log = LogFile(out, again=True).write
        if other:
            line = f"its code of {', '.join(other)} is not the operator's, so results may differ"
            run.report_event("warning", f"{line}: install the same on both hosts")
        folder = self.options.network.certificates
        if folder and (ending := expiring_soon(Path(folder))):
            run.report_event("warning", ending)
        self.agent_runs.add(AgentRun(graph, order, run, self.options.operator_timeout))
        try:
            run.prepare(order.here(plan, str(out)), out / ".ledger")
        except OSError as error:  # a full disk, for example: the other runs here go on
            self.agent_runs.close(order.run)
            raise _cannot_begin(error, out) from None
        except BaseException:
            self.agent_runs.close(order.run)
            raise
        workers = len(run.workers)
        count = f"{workers} worker{'s' * (workers != 1)}"
        self.log_line(f"run {order.run[:8]} of {graph}: {count}, outputs in {out}")

    def _folder(self, run: str) -> Path:
        """The output folder of a run: the folder that an earlier agent made for it, or a new one.

        Its name ends with the agent's name, because agents may share `runs` but not the file of a ledger.
        Raises FollowspotError if it cannot be made.
        """
        ending = f"-{run}-{self.options.name}"
        known = sorted(self.options.runs.glob(f"*{ending}")) if self.options.runs.is_dir() else []
        out = known[-1] if known else self.options.runs / f"{time.strftime('%Y%m%d-%H%M%S')}{ending}"
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _cannot_begin(error, out) from None
        return out

    def start(self, run: str) -> None:
        """Start the stages of a run: all its hosts are ready."""
        agent_run = self.agent_runs.agent_run(run)
        if not agent_run.started:
            agent_run.started = True
            agent_run.run.ask(StartRun())

    def relay(self, order: Relayed) -> None:
        """Send an order to the workers on this host. Raises FollowspotError if it does not fit the plan."""
        run = self.agent_runs.agent_run(order.run).run
        order.check(run.plan, remote=True)
        run.ask(order)


def _cannot_begin(error: OSError, out: Path) -> FollowspotError:
    """Why no output can be written below a folder, with the remedy."""
    text = f"the run cannot begin: {error.strerror} (outputs go to {out.absolute()})"
    remedy = limit_remedy(error, "free space there, or start the agent with another --runs")
    return FollowspotError(f"{text}\n    {remedy}")
