"""A host's part of a run under an agent elsewhere, as the operator's side sees it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import zenoh

from followspot.control.dispatch import Request, RunRequest
from followspot.control.host import HostLost, HostRefused, HostStatus, RunOrder
from followspot.control.lifecycle import CloseRun, EndWorkers, FindRun, PrepareRun, StartRun, StopRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetHostStatus, GetLog, GetStates
from followspot.control.origin import own_origin
from followspot.control.plan_transfer import packed, packed_stages
from followspot.control.relay import Relayed, with_order
from followspot.control.swap import ChangeOrder
from followspot.control.zenoh_rpc import InvalidAnswer, RpcClient
from followspot.errors import FollowspotError
from followspot.graph.change import with_stages
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.host.heartbeat import SILENCE, Heartbeat
from followspot.log.run_log import RunLog
from followspot.operator.abandoned_runs import end_abandoned_runs
from followspot.transport.zenoh.network import UNPROVEN

_PERIOD = 0.2
"""Seconds between two questions for the status."""
_MARGIN = 4
"""How many restarts of a worker may have been missed when its agent died."""
_MOST_WORKERS = 1000
"""Workers that ended here and are named no more, which are still remembered."""
_MOST_NEWS = 400
"""Lines of news from before the agent was started anew."""
_FORGOTTEN = 5.0
"""Seconds for an operator to begin the run again with an agent that was started anew."""
_LOST = {"unknown": "the agent was started anew", "given up": "the agent had given the run up"}
"""What became of an agent's part of a run, by how it knows the run."""
_PREPARING = 30.0
"""Seconds that an agent may take to start its workers."""


class RemoteHost:
    """`Host` over Zenoh; a thread asks for its status and keeps the newest.

    media: folder on this host whose files the agent has below its own --media folder.
    """

    def __init__(
        self, client: RpcClient, name: str, media: Path = Path(), order: RunOrder | None = None
    ) -> None:
        """asker: speaks with the agent; order: that it has taken already, None before `prepare`."""
        self.name = name
        self.run = "" if order is None else order.run
        self.order = order
        self._client = client
        self._media = media
        self.log = RunLog()
        self._logged = -1
        """Number, there, of the newest record that came."""
        self._before: tuple[str, ...] = ()
        """News from before the agent began its part anew."""
        self._trouble = ""
        """Why the agent has no part of the run, where it answers that it has none."""
        self._stopped = False
        self._status = HostStatus((), ())
        self._heard = self._taken = time.monotonic()
        """When the host answered last, and when it did so with the status that is kept, s."""
        self._refused = ""
        """Why what it last said was refused, "" where it was not."""
        self._heartbeat = Heartbeat()
        self._news = threading.Event()
        self._over = threading.Event()
        self._unheard: deque[RunRequest] = deque()
        """Orders that were given while the host did not answer."""
        self._standing: list[Relayed] = []
        """Orders for an agent that is started anew."""
        self._asking = threading.Thread(target=self._keep_asking, name=f"status of {name}", daemon=True)

    def prepare(self, order: RunOrder) -> None:
        """Ship the plan. Raises FollowspotError where the agent refuses, HostLost where it is not there.

        What dead operators of this machine left there is ended before.
        """
        self.run = order.run
        own = self._client.own
        order = replace(order, origin=own_origin("" if own == UNPROVEN else own.name))
        for line in end_abandoned_runs(self._client, self.name, order.origin):
            self._before += (line,)
            self.log.say("warning", line)
        plan = packed(plan_from_data(order.plan), self.name, self._media)
        self.order = replace(order, plan=plan, out=None)
        self._ask(PrepareRun(order=self.order), _PREPARING)
        self.watch()

    def watch(self, *, silent: bool = False) -> None:
        """Begin to ask for the status; the first is there on return. Raises HostLost, FollowspotError.

        silent: whether the host is known not to answer now: then it is asked without waiting for it.
        """
        if not silent:
            self._refresh()
        self._asking.start()

    def start(self) -> None:
        """Begin."""
        self._ask(StartRun(run=self.run))

    def stop(self) -> None:
        """End the sources."""
        self._stopped = True
        self._insist(StopRun(run=self.run))

    def ended(self, workers: Sequence[str]) -> None:
        """These workers, here or elsewhere, have come to their end."""
        assert self.order is not None
        self.order = replace(self.order, over=tuple(workers))
        self._insist(EndWorkers(run=self.run, workers=tuple(workers)))

    def change(self, order: ChangeOrder) -> None:
        """One step of a change; an agent that is started anew begins with the stages as they are then."""
        assert self.order is not None
        stages = packed_stages(order.stages, self._media)
        order = order.model_copy(update={"run": self.run, "stages": stages})
        self._ask(order, _PREPARING)
        if order.step == "take_over":
            plan = with_stages(plan_from_data(self.order.plan), order.stages)
            self.order = replace(self.order, plan=plan_to_data(plan))

    def move(self, order: MoveOrder) -> None:
        """One step of a move; an agent that is started anew begins with the stages as they are then."""
        assert self.order is not None
        plan = order.plan and packed(plan_from_data(order.plan), self.name, self._media)
        order = order.model_copy(update={"run": self.run, "plan": plan})
        self._ask(order, _PREPARING)
        if order.plan is not None and not order.trial:
            self.order = replace(self.order, plan=order.plan)

    def states(self) -> dict[str, Any]:
        """What the stages there last told of their state."""
        return dict(self._ask(GetStates(run=self.run), _PREPARING))

    def relay(self, order: Relayed) -> None:
        """Tell the workers there."""
        assert self.order is not None
        plan = plan_from_data(self.order.plan)
        mine = {stage.name for stage in plan.stages if plan.host_of(stage.worker) == self.name}
        order = order.part_for(mine).model_copy(update={"run": self.run})
        self._standing = with_order(self._standing, order)
        self._insist(order)

    def attend(self, timeout: float) -> None:
        """Wait for news. Raises HostLost where none came for too long."""
        self._news.wait(timeout)
        self._news.clear()
        if self._heartbeat.silent({self.name: self._heard}, time.monotonic()):
            raise HostLost(self._trouble or f"host {self.name} does not answer{self._refused}")

    def status(self) -> HostStatus:
        """The newest status, with its age."""
        status, since = self._status, self._taken
        return status if status.age_s is None else replace(status, age_s=time.monotonic() - since)

    def leave(self) -> None:
        """Ask no more; the run goes on."""
        self._over.set()
        if self._asking.is_alive():
            self._asking.join()

    def close(self) -> bool:
        """End the run there, if it has not ended; False where the host does not answer, and so goes on."""
        self.leave()
        try:
            self._ask(CloseRun(run=self.run))
        except (HostLost, zenoh.ZError):
            return self.order is None
        except FollowspotError:  # it has no such run
            return True
        return True

    def _ask(self, request: Request, timeout: float = 2.0) -> Any:
        return self._client.ask(self.name, request, timeout)

    def _insist(self, request: RunRequest) -> None:
        """Ask now, and again when the host answers, for the link may just be cut."""
        try:
            self._ask(request)
        except HostLost:
            self._unheard.append(request)
        except FollowspotError:
            return

    def _refresh(self) -> None:
        status: HostStatus = self._read(GetHostStatus(run=self.run), SILENCE)
        self._heard = taken = time.monotonic()
        self._trouble = ""
        self._fetch_log(status.logged)  # first, for nobody asks for it once all is seen to be over
        here = {worker.name for worker in status.workers}
        over = (w for w in self._status.workers if w.phase == "over" and w.name not in here)
        ended = islice(over, _MOST_WORKERS)
        workers, news = (*status.workers, *ended), (*self._before, *status.news)
        self._status, self._taken = replace(status, workers=workers, news=news), taken
        self._news.set()

    def _fetch_log(self, newest: int) -> None:
        """What was logged there since; an agent that was started anew counts anew."""
        self._logged = min(self._logged, newest)
        if newest > self._logged:
            page = self._read(GetLog(run=self.run, after=self._logged))
            self._logged = page.last
            self.log.add(*(replace(record, host=self.name) for record in page.records))

    def _read(self, request: Request, timeout: float = 2.0) -> Any:
        """What the host says of itself. Raises FollowspotError; an answer that is invalid is remembered."""
        try:
            found = self._ask(request, timeout)
        except InvalidAnswer as error:
            self._refused = f" in a way that can be believed: {error.why}"[:300]
            raise
        self._refused = ""
        return found

    def _keep_asking(self) -> None:
        while not self._over.wait(_PERIOD):
            with suppress(FollowspotError, zenoh.ZError):
                self._ask_once()

    def _ask_once(self) -> None:
        """Ask for the status, and tell what could not be told before.

        Raises FollowspotError, ZError.
        """
        try:
            self._refresh()
        except HostRefused as error:
            self._trouble = str(error)
            self._take_up_again()
            return
        while self._unheard:
            with suppress(HostRefused):
                self._ask(self._unheard[0])
            self._unheard.popleft()

    def _forgotten(self) -> None:
        """The run is not begun again from here: it has ended, unless whoever operates it does so."""
        if time.monotonic() - self._heard > _FORGOTTEN:
            workers = tuple(replace(worker, phase="over") for worker in self._status.workers)
            self._status = replace(self._status, workers=workers)
            self._news.set()

    def _take_up_again(self) -> None:
        """The agent has no part of the run any more: let it do its part again, unless it is to end.

        The link may be cut at any moment: what follows the preparation is told when the agent answers again.
        """
        order = self.order
        if order is None or (lost := _LOST.get(self._ask(FindRun(run=self.run)))) is None:
            return
        if not order.restart or self._stopped:
            self._forgotten()
            return
        incarnations = {w.name: w.restarts + _MARGIN for w in self._status.workers}
        self._before = (*self._status.news, f"{lost}: its part of the run begins anew")[-_MOST_NEWS:]
        after: list[RunRequest] = [*self._standing, StartRun(run=self.run)]
        self._unheard.extendleft(each for each in reversed(after) if each not in self._unheard)
        try:
            self._ask(PrepareRun(order=replace(order, incarnations=incarnations)), _PREPARING)
        except HostRefused as error:
            self._trouble = f"{error}; it cannot take its part of the run up again"
