"""A host's part of a run under an agent elsewhere, as the operator's side sees it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

import pydantic
import zenoh

from followspot.control.host import HostLost, HostRefused, HostStatus, RunOrder, status_from_data
from followspot.control.move import MoveOrder
from followspot.control.origin import own_origin
from followspot.control.plan_transfer import packed, packed_stages
from followspot.control.swap import ChangeOrder
from followspot.control.tapping import Tapping
from followspot.control.zenoh_rpc import RpcClient
from followspot.errors import FollowspotError
from followspot.graph.change import with_stages
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.host.heartbeat import SILENCE, Heartbeat
from followspot.log.record import page_from_data
from followspot.log.run_log import RunLog
from followspot.operator.abandoned_runs import end_left_behind
from followspot.transport.zenoh.network import UNPROVEN

_T = TypeVar("_T")
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
        self._unheard: deque[tuple[str, dict[str, Any]]] = deque()
        """Orders that were given while the host did not answer."""
        self._taps: list[dict[str, Any]] = []
        self._asking = threading.Thread(target=self._keep_asking, name=f"status of {name}", daemon=True)

    def prepare(self, order: RunOrder) -> None:
        """Ship the plan. Raises FollowspotError where the agent refuses, HostLost where it is not there.

        What dead operators of this machine left there is ended before.
        """
        self.run = order.run
        own = self._client.own
        order = replace(order, origin=own_origin("" if own == UNPROVEN else own.name))
        for line in end_left_behind(self._client, self.name, order.origin):
            self._before += (line,)
            self.log.say("warning", line)
        plan = packed(plan_from_data(order.plan), self.name, self._media)
        self.order = replace(order, plan=plan, out=None)
        self._ask("prepare", _PREPARING, order=self.order.to_data())
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
        self._ask("start", run=self.run)

    def stop(self) -> None:
        """End the sources."""
        self._stopped = True
        self._insist("stop")

    def ended(self, workers: Sequence[str]) -> None:
        """These workers, here or elsewhere, have come to their end."""
        assert self.order is not None
        self.order = replace(self.order, over=tuple(workers))
        self._insist("ended", workers=list(workers))

    def change(self, order: ChangeOrder) -> None:
        """One step of a change; an agent that is started anew begins with the stages as they are then."""
        assert self.order is not None
        order = replace(order, stages=packed_stages(order.stages, self._media))
        self._ask("change", _PREPARING, run=self.run, change=order.to_data())
        if order.step == "take_over":
            plan = with_stages(plan_from_data(self.order.plan), order.stages)
            self.order = replace(self.order, plan=plan_to_data(plan))

    def move(self, order: MoveOrder) -> None:
        """One step of a move; an agent that is started anew begins with the stages as they are then."""
        assert self.order is not None
        if order.plan is not None:
            order = replace(order, plan=packed(plan_from_data(order.plan), self.name, self._media))
        self._ask("move", _PREPARING, run=self.run, move=order.to_data())
        if order.plan is not None and not order.trial:
            self.order = replace(self.order, plan=order.plan)

    def states(self) -> dict[str, Any]:
        """What the stages there last told of their state."""
        return dict(self._ask("states", _PREPARING, run=self.run))

    def tap(self, tappings: Sequence[Tapping]) -> None:
        """Look at ports there."""
        assert self.order is not None
        plan = plan_from_data(self.order.plan)
        here = {worker.name for worker in plan.workers if worker.host == self.name}
        mine = {stage.name for stage in plan.stages if stage.worker in here}
        taps = [asdict(tapping) for tapping in tappings if tapping.port.rpartition(".")[0] in mine]
        self._taps += [tap for tap in taps if tap not in self._taps]
        self._insist("tap", taps=taps)

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
            self._ask("close", run=self.run)
        except (HostLost, zenoh.ZError):
            return self.order is None
        except FollowspotError:  # it has no such run
            return True
        return True

    def _ask(self, verb: str, timeout: float = 2.0, **data: Any) -> Any:
        return self._client.ask(self.name, verb, timeout, **data)

    def _insist(self, verb: str, **data: Any) -> None:
        """Ask now, and again when the host answers, for the link may just be cut."""
        try:
            self._ask(verb, run=self.run, **data)
        except HostLost:
            self._unheard.append((verb, data))
        except FollowspotError:
            return

    def _refresh(self) -> None:
        status = self._read(status_from_data, self._ask("status", SILENCE, run=self.run))
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
            page = self._read(page_from_data, self._ask("log", run=self.run, after=self._logged))
            self._logged = page.last
            self.log.add(*(replace(record, host=self.name) for record in page.records))

    def _read(self, read: Callable[[Any], _T], data: Any) -> _T:
        """What a host says of itself, checked. Raises ValueError; who finds the host silent learns why."""
        try:
            found = read(data)
        except pydantic.ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"]))
            self._refused = f" in a way that can be believed: {where}: {first['msg']}"[:300]
            raise
        self._refused = ""
        return found

    def _keep_asking(self) -> None:
        while not self._over.wait(_PERIOD):
            with suppress(FollowspotError, ValueError, zenoh.ZError):
                self._ask_once()

    def _ask_once(self) -> None:
        """Ask for the status, and tell what could not be told before.

        Raises FollowspotError, ValueError, ZError.
        """
        try:
            self._refresh()
        except HostRefused as error:
            self._trouble = str(error)
            self._take_up_again()
            return
        while self._unheard:
            verb, data = self._unheard[0]
            with suppress(HostRefused):
                self._ask(verb, run=self.run, **data)
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
        if order is None or (lost := _LOST.get(self._ask("knows", run=self.run))) is None:
            return
        if not order.restart or self._stopped:
            self._forgotten()
            return
        incarnations = {w.name: w.restarts + _MARGIN for w in self._status.workers}
        self._before = (*self._status.news, f"{lost}: its part of the run begins anew")[-_MOST_NEWS:]
        after: list[tuple[str, dict[str, Any]]] = [("tap", {"taps": list(self._taps)}), ("start", {})]
        self._unheard.extendleft(each for each in after if each not in self._unheard)
        try:
            self._ask("prepare", _PREPARING, order=replace(order, incarnations=incarnations).to_data())
        except HostRefused as error:
            self._trouble = f"{error}; it cannot take its part of the run up again"
