"""The change that a worker is in: successors that were built, until they take over or are given up."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial

from followspot.control.swap import ChangeOrder, ChangeStatus
from followspot.errors import FollowspotError
from followspot.worker.hot_swap import Replacement, discarded, dry_run, prepared, take_over
from followspot.worker.scheduler import Worker

Answer = Callable[[ChangeStatus], None]
"""Gets what became of a step; from any thread."""


class WorkerChange:
    """At most one change at a time; building goes on beside the work, the rest between two firings."""

    def __init__(self, worker: Worker, answer: Answer) -> None:
        self.worker = worker
        self.answer = answer
        self._id = ""
        self._built: Sequence[Replacement] = ()

    def obey(self, order: ChangeOrder) -> None:
        """Do one step; call between two firings, in the worker's thread."""
        if order.step == "build":
            self._give_up()
            self._id = order.id
            threading.Thread(target=self._build, args=(order,), name="successors", daemon=True).start()
        elif order.id == self._id and order.step == "take_over":
            self._take_over(order)
        elif order.id == self._id:
            self._give_up()

    def close(self) -> None:
        """The worker is over: what was built is not needed."""
        self._give_up()

    def _build(self, order: ChangeOrder) -> None:
        try:
            built = prepared(self.worker, order.stages)
        except FollowspotError as error:
            self.answer(ChangeStatus(order.id, "failed", str(error)))
            return
        if order.id != self._id:
            discarded(built)
            return
        self._built = built
        self.worker.between_firings(partial(self._try_on, order))

    def _try_on(self, order: ChangeOrder) -> None:
        """Who cannot carry on must be known before anybody, in whichever worker, has taken over."""
        if order.id != self._id:
            return
        try:
            dry_run([] if order.fresh else self._built)
        except FollowspotError as error:
            self._built = ()
            self.answer(ChangeStatus(order.id, "failed", str(error)))
        else:
            self.answer(ChangeStatus(order.id, "built"))

    def _take_over(self, order: ChangeOrder) -> None:
        built, self._built, self._id = self._built, (), ""
        try:
            take_over(self.worker, built, fresh=order.fresh)
        except FollowspotError as error:
            self.answer(ChangeStatus(order.id, "failed", str(error)))
        else:
            self.answer(ChangeStatus(order.id, "done"))

    def _give_up(self) -> None:
        built, self._built, self._id = self._built, (), ""
        discarded(built)
