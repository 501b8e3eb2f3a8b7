"""The agent: it stands on a host, starts and supervises workers there, and answers operators."""

from __future__ import annotations

import re
import select
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from followspot.control.host import order_from_data
from followspot.control.move import move_from_data
from followspot.control.plan_transfer import tappings_from_data, unpacked, unpacked_stages
from followspot.control.swap import change_from_data
from followspot.control.zenoh_rpc import RpcClient, RpcServer, agents
from followspot.errors import FollowspotError
from followspot.graph.change import with_stages
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.host.agent_run import AgentRun
from followspot.host.agent_runs import AgentRuns
from followspot.host.clocks.host import HostClock, read_clock
from followspot.host.local_host import LocalHost
from followspot.host.operator_timeout import OPERATOR_TIMEOUT
from followspot.log.file import LogFile
from followspot.plugins.registry import use_plugin_files
from followspot.security.grants import Grants
from followspot.transport.wakeup_event import WakeupEvent
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import close_session, connected, locators

_TURN_MS = 100
"""Longest wait between two looks at the workers, ms."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
"""What a host may be called."""
_RUN = re.compile(r"[0-9a-f]{8,64}")
"""What a run is called."""


@dataclass(frozen=True)
class AgentOptions:
    """What the owner of a host says.

    name: of the host, as rooms and placements know it; grants: what operators may have stages use here;
    runs: folder below which each run gets one for its outputs; plugin_files: one-file plugins installed here;
    clock_offset: what the clock of this host is known to be behind, ns; operator_timeout: seconds without a
    word of its operator after which a run ends here, if it is not to go on alone.
    """

    name: str
    network: Network = Network()
    grants: Grants = Grants()
    runs: Path = Path("runs")
    plugin_files: tuple[str, ...] = ()
    clock_offset: int = 0
    operator_timeout: float = OPERATOR_TIMEOUT


class Agent:
    """Serves until it is stopped. One thread does everything; Zenoh's only ring a bell."""

    def __init__(self, options: AgentOptions, tell: Callable[[str], None] = lambda line: None) -> None:
        """tell: gets lines for the log. Raises FollowspotError where the name or an endpoint is wrong."""
        if NAME.fullmatch(options.name) is None:
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
        self.tell = tell
        self.agent_runs = AgentRuns(options.runs, options.name, tell)
        self._wakeup = WakeupEvent()
        self._stopping = False
        self.session = connected(options.network)
        self.locators = locators(self.session)

    def stop(self) -> None:
        """End all runs, then `serve`. Safe in a signal handler."""
        self._stopping = True
        self._wakeup.set()

    def serve(self) -> None:
        """Answer and supervise until `stop`. Leaves nothing behind."""
        try:
            if self.options.name in agents(self.session, timeout=0.5):
                raise FollowspotError(f"there is an agent {self.options.name} already")
            self._take_up()
            answers = RpcServer(self.session, self.options.name, self._verbs(), self._wakeup.set, self.tell)
            try:
                self._loop(answers)
            finally:
                answers.close()
            self.agent_runs.forget()
        finally:
            for agent_run in self.agent_runs:
                agent_run.run.close()
            self._wakeup.close()
            close_session(self.session)

    def _take_up(self) -> None:
        """Go on where an agent of this name died that had runs without an operator."""
        for order in self.agent_runs.kept.left():
            self.tell(f"run {order.run[:8]}: taken up again")
            try:
                self.prepare(order.to_data())
                self.start(order.run)
            except (FollowspotError, ValueError, OSError) as error:
                self.tell(f"run {order.run[:8]}: cannot be taken up again: {error}")

    def _loop(self, answers: RpcServer) -> None:
        while not (self._stopping and all(agent_run.over for agent_run in self.agent_runs)):
            poll = select.poll()
            for fd in (self._wakeup.fileno(), *(agent_run.run.fileno() for agent_run in self.agent_runs)):
                poll.register(fd, select.POLLIN)
            poll.poll(_TURN_MS)
            self._wakeup.clear()
            answers.answer()
            for agent_run in self.agent_runs:
                agent_run.run.attend(0)
                if self._stopping:
                    agent_run.run.stop()
            self.agent_runs.tidy(time.monotonic())

    def _verbs(self) -> dict[str, Callable[..., Any]]:
        """What operators may ask."""
        return {
            "prepare": self.prepare,
            "start": self.start,
            "stop": lambda run: self.agent_runs.agent_run(run).run.stop(),
            "ended": lambda run, workers: self.agent_runs.agent_run(run).run.ended(
                [str(name) for name in workers]
            ),
            "status": lambda run: self.agent_runs.agent_run(run).run.status().to_data(),
            "change": self.change,
            "move": self.move,
            "tap": self.tap,
            "states": lambda run: self.agent_runs.agent_run(run).run.states(),
            "clock": lambda: read_clock(self.options.clock_offset),
            "close": self.agent_runs.close,
            "knows": self.agent_runs.known,
            "runs": self.agent_runs.listing,
            "log": lambda run, after: self.agent_runs.agent_run(run).run.log.after(int(after)).to_data(),
            "order": lambda run: self.agent_runs.agent_run(run).order.to_data(),
        }

    def prepare(self, order: Any) -> None:
        """Start the workers of a run. Raises FollowspotError, ValueError."""
        found = order_from_data(order)
        name = self.options.name
        if not _RUN.fullmatch(found.run):
            raise FollowspotError(f"{found.run[:80]!r} cannot be the name of a run")
        self.agent_runs.check_room(found.run)
        plan = unpacked(found.plan, name, self.options.grants, self.options.plugin_files)
        graph = plan_from_data(plan).graph
        out = self._folder(found.run)
        hub = (*self.locators, *self.options.network.connect)
        clock = HostClock(RpcClient(self.session, self.options.network.own), self.options.clock_offset)
        run = LocalHost(name, self.options.network, hub, clock)
        self.agent_runs.add(AgentRun(graph, found, run, self.options.operator_timeout))
        run.log.on_log = LogFile(out, again=True).write
        run.prepare(found.here(plan, str(out)), out / ".ledger")
        self.tell(f"run {found.run[:8]} of {graph}: {len(run.workers)} workers, outputs in {out}")

    def _folder(self, run: str) -> Path:
        """The folder of a run: the one that it had before this agent was started, or a new one.

        It bears the agent's name, for agents may share a folder, but not a ledger.
        """
        ending = f"-{run}-{self.options.name}"
        known = sorted(self.options.runs.glob(f"*{ending}")) if self.options.runs.is_dir() else []
        out = known[-1] if known else self.options.runs / f"{time.strftime('%Y%m%d-%H%M%S')}{ending}"
        out.mkdir(parents=True, exist_ok=True)
        return out

    def start(self, run: str) -> None:
        """All hosts are ready."""
        agent_run = self.agent_runs.agent_run(run)
        if not agent_run.started:
            agent_run.started = True
            agent_run.run.start()

    def change(self, run: str, change: Any) -> None:
        """One step of a change to stages that run here. Raises FollowspotError, ValueError."""
        agent_run = self.agent_runs.agent_run(run)
        order = change_from_data(change)
        own = {stage.name for stage in agent_run.run.plan.stages if stage.worker in agent_run.run.workers}
        if strangers := {stage.name for stage in order.stages} - own:
            raise FollowspotError(f"{', '.join(sorted(strangers))} of run {run[:8]} does not run here")
        agent_run.run.change(replace(order, stages=unpacked_stages(order.stages, self.options.grants)))
        if order.step == "take_over":
            plan = with_stages(plan_from_data(agent_run.order.plan), order.stages)
            agent_run.order = replace(agent_run.order, plan=plan_to_data(plan))
            names = ", ".join(stage.name for stage in order.stages)
            self.tell(f"run {run[:8]} of {agent_run.graph}: changed {names}")

    def move(self, run: str, move: Any) -> None:
        """One step of a move of stages to or from here. Raises FollowspotError, ValueError."""
        agent_run = self.agent_runs.agent_run(run)
        order = move_from_data(move)
        if order.plan is not None:
            name, grants = self.options.name, self.options.grants
            plan = unpacked(order.plan, name, grants, self.options.plugin_files)
            if order.trial:
                return
            agent_run.order = replace(agent_run.order, plan=order.plan)
            order = replace(order, plan=plan)
            self.tell(f"run {run[:8]} of {agent_run.graph}: stages moved")
        agent_run.run.move(order)

    def tap(self, run: str, taps: list[dict[str, Any]]) -> None:
        """Look at ports of stages that run here. Raises FollowspotError, ValueError."""
        agent_run = self.agent_runs.agent_run(run)
        agent_run.run.tap(tappings_from_data(taps))
