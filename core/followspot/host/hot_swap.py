"""Hot swap on one host: passes each step to the workers that take part, and collects their answers."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping

from followspot.control.swap import ChangeOrder, ChangePhase, ChangeStatus, Rested, Step
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.host.worker_pool import WorkerPool

_TIMEOUT = 60.0
"""Seconds after which a change that was built but neither taken over nor discarded blocks no other."""
_AFTER: Mapping[Step, ChangePhase] = {
    "build": "built",
    "hold": "held",
    "rest": "resting",
    "take_over": "done",
    "go_on": "done",
    "discard": "done",
}


_LATE: tuple[Step, ...] = ("take_over", "go_on", "discard")
"""Steps that go on without a worker that has died since the steps before."""


class HostSwaps:
    """The hot swaps of a run on this host, one after the other."""

    def __init__(self, pool: WorkerPool) -> None:
        self._pool = pool
        self._change = HostChange()
        self._incarnations: dict[str, int] = {}
        """Incarnation of each worker that builds, or has built, what is new."""

    def carry_out(self, order: ChangeOrder) -> None:
        """Do one step of a hot swap, unless it is being done already. Safe beside `attend`.

        Raises FollowspotError if another change is under way, the run has ended or a worker is not running.
        """
        if self._change.repeats(order):
            return
        if self._change.blocks(order):
            raise FollowspotError("another change is under way; try again when it is done")
        if order.plan is not None:
            self._pool.check_rows(order.plan)
        change, workers = HostChange(order, self._pool.plan), self._pool.workers
        if all(worker.phase == "over" for worker in workers.values()):
            raise FollowspotError("the run has ended")
        if order.step == "build":
            self._incarnations = {name: workers[name].incarnation for name in change.orders}
        away = [name for name in change.orders if not self._takes_part(name)]
        if away and order.step not in _LATE:
            raise FollowspotError(f"worker {away[0]} is not running; try again in a moment")
        self._change = change
        if order.step == "build" and order.plan is not None:
            self._pool.hand_over_rings(order.plan)
        for name, own_order in change.orders.items():
            if name not in away:
                workers[name].channel.send_if_open(own_order)
        for name in away:
            self._leave_out(name)

    def _takes_part(self, name: str) -> bool:
        """True if the worker runs, and has built replacements or is ordered to build them."""
        worker = self._pool.workers[name]
        return worker.phase == "running" and worker.incarnation == self._incarnations.get(name)

    def _leave_out(self, name: str) -> None:
        """Do not wait for a worker that died after the build; it restarts with the new stages."""
        if self._change.died(name):
            self._adopt(self._change.orders[name])
            worker = self._pool.workers[name]
            if worker.busy:
                worker.kill("the graph changed while it began")

    def attend(self, answers: Iterable[tuple[str, ChangeStatus]]) -> None:
        """Take the answers of workers; restarted workers get the stages that have taken over."""
        for name, answer in answers:
            if self._change.take_answer(name, answer):
                self._adopt(self._change.orders[name])

    def attend_deaths(self) -> None:
        """Note the workers that have ended or died in a change."""
        for worker in self._pool.workers.values():
            if not worker.busy and self._change.died(worker.name):
                self._adopt(self._change.orders[worker.name])

    def _adopt(self, order: ChangeOrder) -> None:
        """Give workers that start from now on the stages that have taken over."""
        if order.plan is not None:
            self._pool.adopt(order.plan)
        elif order.stages:
            self._pool.change(order.stages)

    def status(self) -> ChangeStatus:
        """The status of the newest change."""
        return self._change.status()


class HostChange:
    """The newest step of the newest change on this host."""

    def __init__(self, order: ChangeOrder | None = None, plan: Plan | None = None) -> None:
        """order: None before the first change; plan: says which worker has which stage, before the change."""
        self.order = order
        self.orders: dict[str, ChangeOrder] = {}
        """The order for each worker."""
        self._answers: dict[str, ChangeStatus] = {}
        self._expires = time.monotonic() + _TIMEOUT
        if order is not None and order.workers:
            self.orders = dict.fromkeys(order.workers, order)
        elif order is not None and plan is not None:
            for worker in dict.fromkeys(plan.worker_of(stage.name) for stage in order.stages):
                own = tuple(stage for stage in order.stages if plan.worker_of(stage.name) == worker)
                self.orders[worker] = order.model_copy(update={"stages": own, "subgraphs": None})

    def blocks(self, order: ChangeOrder) -> bool:
        """True if another change is under way, so that this order must wait."""
        other = self.order is not None and self.order.id != order.id
        return other and self.status().phase not in ("done", "failed") and time.monotonic() < self._expires

    def repeats(self, order: ChangeOrder) -> bool:
        """True if an order is the last one again: the operator has not got the answer."""
        known = self.order
        return known is not None and (order.id, order.turn, order.step) == (known.id, known.turn, known.step)

    def take_answer(self, worker: str, answer: ChangeStatus) -> bool:
        """Take a worker's answer; return True if its replacements have taken over."""
        if self.order is None or (answer.id, answer.turn) != (self.order.id, self.order.turn):
            return False
        self._answers[worker] = answer
        return answer.phase == "done" and self.order.step == "take_over"

    def died(self, worker: str) -> bool:
        """Note that a worker has ended or died; return True if it must restart with its replacements.

        It must if the order was to take over, because the replacements of other workers may have done so.
        Nothing is left for it to do if the others go on.
        """
        if self.order is None or worker not in self.orders or self._answered(worker):
            return False
        late = self.order.step in _LATE
        why = "" if late else f"worker {worker} has ended"
        self._answers[worker] = ChangeStatus(
            self.order.id, "done" if late else "failed", why, self.order.turn
        )
        return self.order.step == "take_over"

    def status(self) -> ChangeStatus:
        """The status of the change over all workers."""
        if self.order is None:
            return ChangeStatus()
        errors = [answer.error for answer in self._answers.values() if answer.phase == "failed"]
        turn = self.order.turn
        if errors:
            return ChangeStatus(self.order.id, "failed", "; ".join(errors), turn)
        if not all(self._answered(worker) for worker in self.orders):
            return ChangeStatus(self.order.id, "building", turn=turn)
        rested = Rested.of([answer.rested for answer in self._answers.values()])
        return ChangeStatus(self.order.id, _AFTER[self.order.step], turn=turn, rested=rested)

    def _answered(self, worker: str) -> bool:
        """True if a worker has done this step."""
        answer = self._answers.get(worker)
        return answer is not None and self.order is not None and answer.phase == _AFTER[self.order.step]
