"""A change of the graph in several workers: all come to rest at one capture time, then change.

In a replay no source is then ahead of the others and no message is in flight, so the result is that of one
worker. Live sources hold at once, and messages that are not processed in time are counted as lost.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial

from followspot.control.swap import ChangeOrder, ChangePhase, ChangeStatus, Rested
from followspot.errors import FollowspotError
from followspot.worker.change.rewiring import Rewiring
from followspot.worker.rest import REST_TIMEOUT, Rest
from followspot.worker.scheduler import Scheduler

_LIVE_REST_TIMEOUT = 1.0
"""Seconds after which a worker of a live run changes even if it is not at rest."""
_OPERATOR_TIMEOUT = 60.0
"""Seconds after which a worker goes on by itself: its operator has gone."""


class JointChange:
    """The part of one worker in such a change.

    answer: gets the status after each step; forgotten: called if the operator sends no further step.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        answer: Callable[[ChangeStatus], None],
        forgotten: Callable[[], None],
    ) -> None:
        self._scheduler = scheduler
        self._answer = answer
        self._forgotten = forgotten
        self._rewiring: Rewiring | None = None
        self._timer: threading.Timer | None = None

    def carry_out(self, order: ChangeOrder, rewiring: Rewiring | None) -> None:
        """Do one step after "build"; call between two firings. rewiring: what was built."""
        self._expect_another()
        if order.step in ("hold", "rest") and self._rewiring is None and rewiring is not None:
            self._rewiring = rewiring
            self._scheduler.sources.hold.freeze()
            self._scheduler.ends.report_at_once(True)
        if order.step == "hold" and self._rewiring is not None:
            self._tell(order, "held", Rested(self._scheduler.sources.hold.newest, self._rewiring.window))
        elif order.step == "rest" and self._rewiring is not None:
            self._rest(order, self._rewiring)
        elif order.step == "take_over" and self._rewiring is not None:
            self._take_over(order, self._rewiring)
        elif order.step == "go_on":
            self.release()
            self._tell(order, "done")

    @property
    def holds(self) -> bool:
        """Whether the sources hold for the change."""
        return self._rewiring is not None

    def release(self) -> None:
        """Let the sources go on, with the stages and edges that are there."""
        if self._timer is not None:
            self._timer.cancel()
        if self._rewiring is not None:
            self._rewiring.close_old()
            self._rewiring = None
            self._scheduler.sources.hold.set_free()
            self._scheduler.ends.report_at_once(False)

    def _expect_another(self) -> None:
        """Go on without the operator if no other step follows."""
        if self._timer is not None:
            self._timer.cancel()
        self._timer = threading.Timer(_OPERATOR_TIMEOUT, self._scheduler.between_firings, (self._forgotten,))
        self._timer.daemon = True
        self._timer.start()

    def _rest(self, order: ChangeOrder, rewiring: Rewiring) -> None:
        """Answer once the sources have sent everything up to a capture time and nothing is left to do."""
        if order.until >= 0:
            self._scheduler.sources.hold.align(order.until)
        rewiring.leave(order.leaving)
        deadline = time.monotonic() + (_LIVE_REST_TIMEOUT if rewiring.wiring.live else REST_TIMEOUT)
        self._scheduler.at_rest(Rest(partial(self._rested, order, rewiring), deadline, self._calm))

    def _calm(self) -> bool:
        ends = self._scheduler.ends
        return ends.all_sent() and ends.nothing_in_transit() and not ends.credit_came()

    def _rested(self, order: ChangeOrder, rewiring: Rewiring, reached: bool) -> None:
        if not (reached or rewiring.wiring.live):
            self._fail(order, f"the stages did not come to rest within {REST_TIMEOUT:.0f} s")
            return
        try:
            if not order.fresh:
                rewiring.dry_run()
        except FollowspotError as error:
            self._fail(order, str(error))
        else:
            self._tell(order, "resting", Rested(activity=self._scheduler.activity))

    def _take_over(self, order: ChangeOrder, rewiring: Rewiring) -> None:
        try:
            rewiring.take_over(fresh=order.fresh)
        except FollowspotError as error:
            self._fail(order, str(error))
        else:
            self._tell(order, "done")

    def _tell(self, order: ChangeOrder, phase: ChangePhase, rested: Rested = Rested()) -> None:
        self._answer(ChangeStatus(order.id, phase, turn=order.turn, rested=rested))

    def _fail(self, order: ChangeOrder, why: str) -> None:
        self._answer(ChangeStatus(order.id, "failed", why, order.turn))
