"""All runs of an agent. Ends runs whose operator has timed out, and forgets runs that are over."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

from followspot.control.lifecycle import Known, ListedRun
from followspot.errors import FollowspotError
from followspot.host.agent_run import AgentRun
from followspot.host.kept_runs import KeptRuns

MAX_RUNS = 16
_KEEP_ENDED = 600.0
"""Seconds that the last status of an ended detached run is kept for an operator to fetch."""
_MAX_TIMED_OUT = 256
"""Most names of runs that are remembered after their operator has timed out."""


class AgentRuns:
    """The runs of an agent, by name. kept: saves the detached ones."""

    def __init__(self, runs: Path, host: str, log_line: Callable[[str], None]) -> None:
        """runs, host: see `KeptRuns`; log_line: gets lines for the log."""
        self.kept = KeptRuns(runs, host)
        self._log_line = log_line
        self._runs: dict[str, AgentRun] = {}
        self._timed_out: deque[str] = deque(maxlen=_MAX_TIMED_OUT)

    def __iter__(self) -> Iterator[AgentRun]:
        return iter(tuple(self._runs.values()))

    def agent_run(self, run: str) -> AgentRun:
        """The run of this name; restarts its operator timeout. Raises FollowspotError if there is none."""
        agent_run = self._runs.get(run)
        if agent_run is None or agent_run.operator.timed_out:
            raise FollowspotError(f"there is no run {run!r} here")
        agent_run.operator.note_request(time.monotonic())
        return agent_run

    def known(self, run: str) -> Known:
        """Whether the agent has this run, or has ended it because its operator timed out."""
        if run in self._timed_out:
            return "timed out"
        return "here" if run in self._runs else "unknown"

    def check_capacity(self, run: str) -> None:
        """Make room for a run. Raises FollowspotError if it cannot be added."""
        if self.known(run) == "timed out":
            self.close(run)
        if run in self._runs:
            raise FollowspotError(f"the run {run!r} is here already")
        if len(self._runs) >= MAX_RUNS:
            for agent_run in [agent_run for agent_run in self if agent_run.over]:
                self.close(agent_run.order.run)
        if len(self._runs) >= MAX_RUNS:
            raise FollowspotError(f"this host has {MAX_RUNS} runs already, and takes no more")

    def add(self, agent_run: AgentRun) -> None:
        """Add a run, which may have timed out before."""
        run = agent_run.order.run
        self._runs[run] = agent_run
        if run in self._timed_out:
            self._timed_out.remove(run)

    def close(self, run: str, *, resumable: bool = False) -> None:
        """Forget a run; kill its workers that are still alive. resumable: a later agent may resume it."""
        agent_run = self._runs.pop(run, None)
        if agent_run is not None:
            agent_run.run.close()
            if not resumable:
                self.kept.forget(agent_run)
            self._log_line(f"run {run[:8]} of {agent_run.graph}: over")

    def tidy(self, now: float) -> None:
        """Check operator timeouts, close ended runs, save detached ones. now: monotonic time, s."""
        for agent_run in self:
            run = agent_run.order.run
            if (line := agent_run.operator.check(now)) and not agent_run.over:
                agent_run.run.report_event("warning" if agent_run.operator.silent else "info", line)
                self._log_line(f"run {run[:8]} of {agent_run.graph}: {line}")
            if agent_run.operator.timed_out and run not in self._timed_out:
                self._timed_out.append(run)
                agent_run.leave(now)
            if agent_run.left(now) or (
                agent_run.order.detached and agent_run.over and agent_run.operator.seconds(now) > _KEEP_ENDED
            ):
                self.close(run, resumable=agent_run.leaving)
        self.kept.keep(self, now)

    def forget(self) -> None:
        """Remove all saved orders, so that no later agent resumes a run."""
        for agent_run in self:
            self.kept.forget(agent_run)

    def listing(self) -> list[ListedRun]:
        """All runs, as the answer to `ListRuns`."""
        now = time.monotonic()
        return [
            ListedRun(
                run=agent_run.order.run,
                graph=agent_run.graph,
                over=agent_run.over,
                detached=agent_run.order.detached,
                silent_s=agent_run.operator.seconds(now),
                operator=agent_run.order.operator,
                fired=max((worker.fired for worker in agent_run.run.status().workers), default=0),
                age_s=now - agent_run.began,
                folder=agent_run.run.out,
            )
            for agent_run in self
        ]
