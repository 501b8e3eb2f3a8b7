"""A host's part of a run as its agent keeps it, also on disk where it goes on without an operator.

An agent that is started anew takes such parts up again: workers begin with higher numbers than those that
ended with the agent before, and with no state but what others send them.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from followspot.control.host import RunOrder
from followspot.control.lifecycle import PrepareRun
from followspot.control.move import MoveOrder
from followspot.files import read_bytes
from followspot.host.local_host import LocalHost
from followspot.host.operator_timeout import OPERATOR_TIMEOUT, Absence

_FILE = ".order"
_FRESH = 600.0
"""Seconds since an agent last kept a part after which it is not taken up again."""
_PERIOD = 2.0
"""Seconds between two times that it keeps them."""
_MARGIN = 4
"""Starts of a worker that may have been missed."""
_LEAVING = 5.0
"""Seconds that workers whose operator does not come back have to complete their outputs."""


class AgentRun:
    """A run on this host, and who looks after it.

    operator_timeout: seconds without its operator after which it is given up, where it is not to go on alone.
    """

    def __init__(
        self, graph: str, order: RunOrder, run: LocalHost, operator_timeout: float = OPERATOR_TIMEOUT
    ) -> None:
        self.graph = graph
        self.order = order
        self.run = run
        self.operator = Absence(None if order.detached else operator_timeout, time.monotonic())
        self.started = False
        self._left_until: float | None = None

    @property
    def over(self) -> bool:
        """Whether all its workers have ended."""
        return self.run.status().all("over")

    def leave(self, now: float) -> None:
        """Let the workers go as those do whose places others take: outputs are complete, streams not over.

        now: monotonic time, s.
        """
        self._left_until = now + _LEAVING
        self.run.move(MoveOrder(leaving=tuple(self.run.workers)))

    def left(self, now: float) -> bool:
        """Whether they have left, or had the time to."""
        return self._left_until is not None and (
            now > self._left_until or self.run.status().all("absent", "over")
        )

    def again(self) -> RunOrder:
        """The order for whoever takes it up where it is now."""
        workers = self.run.status().workers
        over = {*self.order.over, *(worker.name for worker in workers if worker.phase == "over")}
        incarnations = {worker.name: worker.restarts + _MARGIN for worker in workers}
        return replace(self.order, incarnations=incarnations, over=tuple(sorted(over)))


class KeptRuns:
    """Parts that go on alone, in the folders of their outputs."""

    def __init__(self, runs: Path, host: str) -> None:
        """runs: folder below which each run has one; host: whose parts."""
        self._runs = runs
        self._host = host
        self._next = 0.0

    def left(self) -> Iterator[RunOrder]:
        """What an agent of this host was at when it died, not long ago."""
        for path in sorted(self._runs.glob(f"*-{self._host}/{_FILE}")):
            with suppress(OSError, ValueError):  # it was just being written, or is of another version
                if time.time() - path.stat().st_mtime > _FRESH:
                    continue
                order = PrepareRun.model_validate_json(read_bytes(path)).order
                if path.parent.name.endswith(f"-{order.run}-{self._host}"):
                    yield order

    def keep(self, agent_runs: Iterable[AgentRun], now: float) -> None:
        """Write down where parts are that go on alone, now and then; now: monotonic time, s."""
        if now < self._next:
            return
        self._next = now + _PERIOD
        for agent_run in agent_runs:
            if agent_run.over:
                self.forget(agent_run)
            elif agent_run.order.detached and agent_run.started:
                path = Path(agent_run.run.out, _FILE)
                with suppress(OSError):  # a full disk must not end the run
                    new = path.with_suffix(".new")
                    new.write_text(PrepareRun(order=agent_run.again()).model_dump_json())
                    new.replace(path)

    def forget(self, agent_run: AgentRun) -> None:
        """It is over."""
        with suppress(OSError):
            Path(agent_run.run.out, _FILE).unlink(missing_ok=True)
