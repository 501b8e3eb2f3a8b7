"""A change on one host: which of its workers have a part in it, and what they have answered."""

from __future__ import annotations

import time
from collections.abc import Mapping

from followspot.control.swap import ChangeOrder, ChangePhase, ChangeStatus, Step
from followspot.graph.plan import Plan

_ABANDONED = 60.0
"""Seconds after which a change that was built and neither taken over nor given up stands in nobody's way."""
_AFTER: Mapping[Step, ChangePhase] = {"build": "built", "take_over": "done", "discard": "done"}


class HostChange:
    """The newest step of the newest change."""

    def __init__(self, order: ChangeOrder | None = None, plan: Plan | None = None) -> None:
        """plan: tells which worker of this host has which of the stages."""
        self.order = order
        self.parts: dict[str, ChangeOrder] = {}
        """What each worker is to do."""
        self._answers: dict[str, ChangeStatus] = {}
        self._until = time.monotonic() + _ABANDONED
        if order is not None and plan is not None:
            for worker in dict.fromkeys(plan.worker_of(stage.name) for stage in order.stages):
                own = tuple(stage for stage in order.stages if plan.worker_of(stage.name) == worker)
                self.parts[worker] = order.model_copy(update={"stages": own})

    def in_the_way_of(self, order: ChangeOrder) -> bool:
        """Whether another change is under way, so that this order has to wait."""
        other = self.order is not None and self.order.id != order.id
        return other and self.status().phase in ("building", "built") and time.monotonic() < self._until

    def heard(self, worker: str, answer: ChangeStatus) -> bool:
        """A worker's answer; whether its successors have taken over."""
        if self.order is None or answer.id != self.order.id:
            return False
        self._answers[worker] = answer
        return answer.phase == "done"

    def died(self, worker: str) -> bool:
        """A worker has ended or died; it answers no more. Whether it is to come back with its successors.

        It is where it was told to let them take over: those of other workers may have done so.
        """
        if self.order is None or worker not in self.parts or self._answered(worker):
            return False
        if self.order.step == "take_over":
            self._answers[worker] = ChangeStatus(self.order.id, "done")
            return True
        self._answers[worker] = ChangeStatus(self.order.id, "failed", f"worker {worker} has ended")
        return False

    def status(self) -> ChangeStatus:
        """Of all workers together."""
        if self.order is None:
            return ChangeStatus()
        errors = [answer.error for answer in self._answers.values() if answer.phase == "failed"]
        if errors:
            return ChangeStatus(self.order.id, "failed", "; ".join(errors))
        if self.order.step != "discard" and not all(self._answered(worker) for worker in self.parts):
            return ChangeStatus(self.order.id, "building")
        return ChangeStatus(self.order.id, _AFTER[self.order.step])

    def _answered(self, worker: str) -> bool:
        """Whether a worker has done what this step asks."""
        answer = self._answers.get(worker)
        return answer is not None and self.order is not None and answer.phase == _AFTER[self.order.step]
