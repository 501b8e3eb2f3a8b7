"""The agent: it stands on a host, starts and supervises workers there, and answers operators."""

from __future__ import annotations

import re
import select
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from followspot.deploy.absence import OPERATOR_TIMEOUT
from followspot.deploy.changes.move_order import move_from_data
from followspot.deploy.changes.order import change_from_data
from followspot.deploy.clocks.host import HostClock, read_clock
from followspot.deploy.host import order_from_data
from followspot.deploy.host_run import HostRun
from followspot.deploy.log.file import LogFile
from followspot.deploy.parcel import tappings_from_data, unpacked, unpacked_stages
from followspot.deploy.part import Part
from followspot.deploy.parts import Parts
from followspot.deploy.requests import Answers, Asker, agents
from followspot.deploy.security.grants import Grants
from followspot.errors import FollowspotError
from followspot.graph.change import with_stages
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.plugins.registry import use_plugin_files
from followspot.transport.bell import Bell
from followspot.transport.zenoh_network import Network
from followspot.transport.zenoh_session import close_session, connected, locators

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
        self.parts = Parts(options.runs, options.name, tell)
        self._bell = Bell()
        self._stopping = False
        self.session = connected(options.network)
        self.locators = locators(self.session)

    def stop(self) -> None:
        """End all runs, then `serve`. Safe in a signal handler."""
        self._stopping = True
        self._bell.ring()

    def serve(self) -> None:
        """Answer and supervise until `stop`. Leaves nothing behind."""
        try:
            if self.options.name in agents(self.session, timeout=0.5):
                raise FollowspotError(f"there is an agent {self.options.name} already")
            self._take_up()
            answers = Answers(self.session, self.options.name, self._verbs(), self._bell.ring, self.tell)
            try:
                self._loop(answers)
            finally:
                answers.close()
            self.parts.forget()
        finally:
            for part in self.parts:
                part.run.close()
            self._bell.close()
            close_session(self.session)

    def _take_up(self) -> None:
        """Go on where an agent of this name died that had runs without an operator."""
        for order in self.parts.kept.left():
            self.tell(f"run {order.run[:8]}: taken up again")
            try:
                self.prepare(order.to_data())
                self.start(order.run)
            except (FollowspotError, ValueError, OSError) as error:
                self.tell(f"run {order.run[:8]}: cannot be taken up again: {error}")

    def _loop(self, answers: Answers) -> None:
        while not (self._stopping and all(part.over for part in self.parts)):
            poll = select.poll()
            for fd in (self._bell.fileno(), *(part.run.fileno() for part in self.parts)):
                poll.register(fd, select.POLLIN)
            poll.poll(_TURN_MS)
            self._bell.hush()
            answers.answer()
            for part in self.parts:
                part.run.attend(0)
                if self._stopping:
                    part.run.stop()
            self.parts.tidy(time.monotonic())

    def _verbs(self) -> dict[str, Callable[..., Any]]:
        """What operators may ask."""
        return {
            "prepare": self.prepare,
            "start": self.start,
            "stop": lambda run: self.parts.part(run).run.stop(),
            "ended": lambda run, workers: self.parts.part(run).run.ended([str(name) for name in workers]),
            "status": lambda run: self.parts.part(run).run.status().to_data(),
            "change": self.change,
            "move": self.move,
            "tap": self.tap,
            "states": lambda run: self.parts.part(run).run.states(),
            "clock": lambda: read_clock(self.options.clock_offset),
            "close": self.parts.close,
            "knows": self.parts.known,
            "runs": self.parts.listing,
            "log": lambda run, after: self.parts.part(run).run.log.after(int(after)).to_data(),
            "order": lambda run: self.parts.part(run).order.to_data(),
        }

    def prepare(self, order: Any) -> None:
        """Start the workers of a run. Raises FollowspotError, ValueError."""
        found = order_from_data(order)
        name = self.options.name
        if not _RUN.fullmatch(found.run):
            raise FollowspotError(f"{found.run[:80]!r} cannot be the name of a run")
        self.parts.check_room(found.run)
        plan = unpacked(found.plan, name, self.options.grants, self.options.plugin_files)
        graph = plan_from_data(plan).graph
        out = self._folder(found.run)
        hub = (*self.locators, *self.options.network.connect)
        clock = HostClock(Asker(self.session, self.options.network.own), self.options.clock_offset)
        run = HostRun(name, self.options.network, hub, clock)
        self.parts.add(Part(graph, found, run, self.options.operator_timeout))
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
        part = self.parts.part(run)
        if not part.started:
            part.started = True
            part.run.start()

    def change(self, run: str, change: Any) -> None:
        """One step of a change to stages that run here. Raises FollowspotError, ValueError."""
        part = self.parts.part(run)
        order = change_from_data(change)
        own = {stage.name for stage in part.run.plan.stages if stage.worker in part.run.workers}
        if strangers := {stage.name for stage in order.stages} - own:
            raise FollowspotError(f"{', '.join(sorted(strangers))} of run {run[:8]} does not run here")
        part.run.change(replace(order, stages=unpacked_stages(order.stages, self.options.grants)))
        if order.step == "take_over":
            plan = with_stages(plan_from_data(part.order.plan), order.stages)
            part.order = replace(part.order, plan=plan_to_data(plan))
            names = ", ".join(stage.name for stage in order.stages)
            self.tell(f"run {run[:8]} of {part.graph}: changed {names}")

    def move(self, run: str, move: Any) -> None:
        """One step of a move of stages to or from here. Raises FollowspotError, ValueError."""
        part = self.parts.part(run)
        order = move_from_data(move)
        if order.plan is not None:
            name, grants = self.options.name, self.options.grants
            plan = unpacked(order.plan, name, grants, self.options.plugin_files)
            if order.trial:
                return
            part.order = replace(part.order, plan=order.plan)
            order = replace(order, plan=plan)
            self.tell(f"run {run[:8]} of {part.graph}: stages moved")
        part.run.move(order)

    def tap(self, run: str, taps: list[dict[str, Any]]) -> None:
        """Look at ports of stages that run here. Raises FollowspotError, ValueError."""
        part = self.parts.part(run)
        part.run.tap(tappings_from_data(taps))
