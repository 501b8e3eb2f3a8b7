"""A run on the host of an agent, with the time since its operator was heard."""

from __future__ import annotations

import time
from dataclasses import replace

from followspot.control.host import RunOrder
from followspot.control.lifecycle import StopRun
from followspot.control.move import MoveOrder
from followspot.host.local_host import LocalHost
from followspot.host.operator_timeout import OPERATOR_TIMEOUT, OperatorTimeout

_RESTART_MARGIN = 4
"""Starts of a worker that may be missing in the saved order."""
_LEAVE_TIMEOUT = 5.0
"""Seconds that workers have to complete their outputs after the operator timeout."""


class AgentRun:
    """A run on this host, with its order and the timeout of its operator.

    operator_timeout: seconds without a request of its operator after which a run that is not detached ends.
    """

    def __init__(
        self, graph: str, order: RunOrder, run: LocalHost, operator_timeout: float = OPERATOR_TIMEOUT
    ) -> None:
        self.graph = graph
        self.order = order
        self.run = run
        self.operator = OperatorTimeout(None if order.detached else operator_timeout, time.monotonic())
        self.started = False
        self.began = time.monotonic() - order.age_s
        self._leave_deadline: float | None = None

    @property
    def over(self) -> bool:
        """True if all its workers have ended."""
        return self.run.status().all("over")

    def end(self, now: float) -> None:
        """End the part of this host, because its agent ends; call it until no worker is at work.

        A run on this host alone ends as by Ctrl-C. Of others the workers leave: hosts that read their streams
        or send to them go on without them, until an agent of this name is there again. now: monotonic, s.
        """
        plan = self.run.plan
        if all(plan.host_of(worker.name) == self.run.name for worker in plan.workers):
            self.run.ask(StopRun())
        elif not self.leaving:
            self.leave(now)

    def leave(self, now: float) -> None:
        """Make the workers exit as in a move: outputs are complete, but streams do not count as ended.

        now: monotonic time, s.
        """
        self._leave_deadline = now + _LEAVE_TIMEOUT
        self.run.ask(MoveOrder(leaving=tuple(self.run.workers)))

    @property
    def leaving(self) -> bool:
        """True from `leave` on."""
        return self._leave_deadline is not None

    def left(self, now: float) -> bool:
        """True if the workers have left, or the time for that is over."""
        return self._leave_deadline is not None and (
            now > self._leave_deadline or self.run.status().all("absent", "over")
        )

    def resume_order(self) -> RunOrder:
        """Order that resumes the run from its present state."""
        workers = self.run.status().workers
        over = {*self.order.over, *(worker.name for worker in workers if worker.phase == "over")}
        incarnations = {worker.name: worker.restarts + _RESTART_MARGIN for worker in workers}
        fired = {worker.name: worker.fired for worker in workers}
        age = time.monotonic() - self.began
        return replace(
            self.order, incarnations=incarnations, fired=fired, age_s=age, over=tuple(sorted(over))
        )
