"""All parts of runs that an agent has: found for whoever asks, ended when nobody does any more."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

from followspot.control.lifecycle import Known, ListedRun
from followspot.errors import FollowspotError
from followspot.host.agent_run import AgentRun, KeptRuns

MAX_RUNS = 16
_KEPT = 600.0
"""Seconds that the last status of a run that goes on alone is kept for an operator to fetch."""
_REMEMBERED = 256
"""How many runs that were given up are remembered by name."""


class AgentRuns:
    """By the name of the run.

    kept: remembers those that go on alone.
    """

    def __init__(self, runs: Path, host: str, tell: Callable[[str], None]) -> None:
        """runs, host: as `KeptRuns` takes them; tell: gets lines for the log."""
        self.kept = KeptRuns(runs, host)
        self._tell = tell
        self._parts: dict[str, AgentRun] = {}
        self._given_up: deque[str] = deque(maxlen=_REMEMBERED)

    def __iter__(self) -> Iterator[AgentRun]:
        return iter(tuple(self._parts.values()))

    def agent_run(self, run: str) -> AgentRun:
        """The part of a run whose operator asks for it now. Raises FollowspotError where there is none."""
        agent_run = self._parts.get(run)
        if agent_run is None or agent_run.operator.discarded:
            raise FollowspotError(f"there is no run {run!r} here")
        agent_run.operator.heard(time.monotonic())
        return agent_run

    def known(self, run: str) -> Known:
        """Whether there is a part of this run."""
        if run in self._given_up:
            return "given up"
        return "here" if run in self._parts else "unknown"

    def check_room(self, run: str) -> None:
        """Raises FollowspotError where no part of this run can be added."""
        if self.known(run) == "given up":
            self.close(run)
        if run in self._parts:
            raise FollowspotError(f"the run {run!r} is here already")
        if len(self._parts) >= MAX_RUNS:
            for agent_run in [agent_run for agent_run in self if agent_run.over]:
                self.close(agent_run.order.run)
        if len(self._parts) >= MAX_RUNS:
            raise FollowspotError(f"this host has parts of {MAX_RUNS} runs already, and takes no more")

    def add(self, agent_run: AgentRun) -> None:
        """One more; it may have been given up before."""
        run = agent_run.order.run
        self._parts[run] = agent_run
        if run in self._given_up:
            self._given_up.remove(run)

    def close(self, run: str) -> None:
        """Forget a run; what still lives is killed."""
        agent_run = self._parts.pop(run, None)
        if agent_run is not None:
            agent_run.run.close()
            self.kept.forget(agent_run)
            self._tell(f"run {run[:8]} of {agent_run.graph}: over")

    def tidy(self, now: float) -> None:
        """End what nobody wants any more, forget what nobody fetched, remember the rest. now: the time, s."""
        for agent_run in self:
            run = agent_run.order.run
            if (line := agent_run.operator.look(now)) and not agent_run.over:
                agent_run.run.tell("warning" if agent_run.operator.silent else "info", line)
                self._tell(f"run {run[:8]} of {agent_run.graph}: {line}")
            if agent_run.operator.discarded and run not in self._given_up:
                self._given_up.append(run)
                agent_run.leave(now)
            if agent_run.left(now) or (
                agent_run.order.detached and agent_run.over and agent_run.operator.seconds(now) > _KEPT
            ):
                self.close(run)
        self.kept.keep(self, now)

    def forget(self) -> None:
        """None of them is to be taken up again."""
        for agent_run in self:
            self.kept.forget(agent_run)

    def listing(self) -> list[ListedRun]:
        """All of them."""
        now = time.monotonic()
        return [
            ListedRun(
                part.order.run,
                part.graph,
                part.over,
                part.order.detached,
                part.operator.seconds(now),
                part.order.origin,
            )
            for part in self
        ]
