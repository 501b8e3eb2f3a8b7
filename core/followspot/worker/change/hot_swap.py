"""Hot swap: new stages are built beside the working ones, and take their places between two firings."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from followspot.control.swap import ChangeOrder, ChangeStatus
from followspot.errors import FollowspotError
from followspot.worker.change.joint_change import JointChange
from followspot.worker.change.replacement import (
    Replacement,
    build_replacements,
    discard_all,
    dry_run,
    take_over,
)
from followspot.worker.change.rewiring import Rewiring
from followspot.worker.rest import REST_TIMEOUT, Rest
from followspot.worker.scheduler import Scheduler

_LIVE_REST_TIMEOUT = 2.0
"""Seconds after which a live graph changes all the same, if it is never between two sets of messages."""
Answer = Callable[[ChangeStatus], None]
"""Called with the outcome of a step, from any thread."""
Rewire = Callable[[dict[str, Any]], Rewiring]
"""Builds what a plan, in JSON types, adds to the worker. Raises FollowspotError."""


class HotSwap:
    """The change that a worker is in: at most one at a time.

    What is new is built in a thread beside the work; the rest happens between two firings.
    """

    def __init__(self, scheduler: Scheduler, answer: Answer, rewire: Rewire) -> None:
        self.scheduler = scheduler
        self._joint = JointChange(scheduler, answer, self._give_up)
        self.answer = answer
        self._rewire = rewire
        self._id = ""
        self._built: Sequence[Replacement] = ()
        self._rewiring: Rewiring | None = None
        self._beside = threading.Lock()
        """Held by the thread that builds."""

    def carry_out(self, order: ChangeOrder) -> None:
        """Do one step; call between two firings, in the worker's thread."""
        if order.step == "discard":
            if order.id == self._id:
                self._give_up()
            self._do_beside(self._tell_discarded, order)
        elif order.step == "build" and not self._joint.holds:
            self._give_up()
            self._id = order.id
            self._do_beside(self._build, order)
        elif order.id != self._id:
            self.answer(ChangeStatus(order.id, "failed", "another change is under way", order.turn))
        elif order.step in ("hold", "rest", "go_on") or self._joint.holds:
            self._joint.carry_out(order, self._rewiring)
            if order.step == "take_over":
                self._rewiring = None
        else:
            self._take_over(order)

    def close(self) -> None:
        """Discard the new stages: the worker has ended."""
        self._give_up()

    def _do_beside(self, step: Callable[[ChangeOrder], None], order: ChangeOrder) -> None:
        """Do a step in a thread beside the work, after the one that may be under way there."""

        def do() -> None:
            with self._beside:
                step(order)

        threading.Thread(target=do, name="replacements", daemon=True).start()

    def _tell_discarded(self, order: ChangeOrder) -> None:
        self.answer(ChangeStatus(order.id, "done", turn=order.turn))

    def _build(self, order: ChangeOrder) -> None:
        """Build the new stages, then order the dry run between two firings; answers if building fails."""
        built: Sequence[Replacement] = ()
        rewiring: Rewiring | None = None
        try:
            if order.plan is None:
                built = build_replacements(self.scheduler, order.stages)
            else:
                rewiring = self._rewire(order.plan)
                rewiring.wait_matched(lambda: order.id == self._id)
        except FollowspotError as error:
            _discard(built, rewiring)
            self.answer(ChangeStatus(order.id, "failed", str(error), order.turn))
            return
        if order.id != self._id:
            _discard(built, rewiring)
            return
        self._built, self._rewiring = built, rewiring
        self.scheduler.between_firings(partial(self._dry_run, order))

    def _dry_run(self, order: ChangeOrder) -> None:
        """Find out whether the replacements can carry on, before any worker lets one take over."""
        if order.id != self._id:
            return
        try:
            if not order.fresh:
                dry_run(self._built)
                if self._rewiring is not None:
                    self._rewiring.dry_run()
        except FollowspotError as error:
            self._built, self._rewiring = (), None
            self.answer(ChangeStatus(order.id, "failed", str(error), order.turn))
        else:
            self.answer(ChangeStatus(order.id, "built", turn=order.turn))

    def _take_over(self, order: ChangeOrder) -> None:
        """Let the new stages take over: at once, or at rest if stages or edges come or go."""
        if self._rewiring is not None:
            timeout = _LIVE_REST_TIMEOUT if self._rewiring.wiring.live else REST_TIMEOUT
            act, rewiring = partial(self._rewire_at, order), self._rewiring
            self.scheduler.sources.hold.align(self.scheduler.sources.hold.newest + rewiring.window)
            self.scheduler.at_rest(Rest(act, time.monotonic() + timeout, rewiring.calm))
            return
        built, self._built, self._id = self._built, (), ""
        try:
            take_over(self.scheduler, built, fresh=order.fresh)
        except FollowspotError as error:
            self.answer(ChangeStatus(order.id, "failed", str(error), order.turn))
        else:
            self.answer(ChangeStatus(order.id, "done", turn=order.turn))

    def _rewire_at(self, order: ChangeOrder, rests: bool) -> None:
        """Put new stages and edges in. rests: whether all that the sources sent has been processed."""
        rewiring = self._rewiring
        if rewiring is None or order.id != self._id:
            self.scheduler.sources.hold.set_free()
            return
        self._rewiring, self._id = None, ""
        try:
            if not (rests or rewiring.wiring.live):
                rewiring.discard()
                raise FollowspotError(f"the stages did not come to rest within {REST_TIMEOUT:.0f} s")
            rewiring.leave()
            rewiring.take_over(fresh=order.fresh)
            rewiring.close_old()
        except FollowspotError as error:
            self.answer(ChangeStatus(order.id, "failed", str(error), order.turn))
        else:
            self.answer(ChangeStatus(order.id, "done", turn=order.turn))
        finally:
            self.scheduler.sources.hold.set_free()

    def _give_up(self) -> None:
        self._joint.release()
        built, self._built, self._id = self._built, (), ""
        rewiring, self._rewiring = self._rewiring, None
        _discard(built, rewiring)


def _discard(built: Sequence[Replacement], rewiring: Rewiring | None) -> None:
    discard_all(built)
    if rewiring is not None:
        rewiring.discard()
