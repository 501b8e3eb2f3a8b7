"""A remote host in a run: the operator asks its agent over Zenoh."""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import zenoh

from followspot.control.dispatch import Dispatcher, Request, RunRequest
from followspot.control.host import HostLost, HostRefused, HostStatus, RunOrder
from followspot.control.lifecycle import CloseRun, EndWorkers, FindRun, PrepareRun, StartRun, StopRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetHostStatus, GetLog, GetStates
from followspot.control.origin import own_origin
from followspot.control.plan_transfer import packed, packed_stages
from followspot.control.relay import Relayed
from followspot.control.swap import ChangeOrder
from followspot.control.worker_orders import RELAYED
from followspot.control.zenoh_rpc import InvalidAnswer, RpcClient
from followspot.errors import FollowspotError
from followspot.graph.change import with_stages
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.host.heartbeat import SILENCE, Heartbeat
from followspot.log.run_log import RunLog
from followspot.operator.abandoned_runs import end_abandoned_runs
from followspot.transport.zenoh.network import UNPROVEN

_POLL_PERIOD = 0.2
"""Seconds between two polls of the agent's status."""
_RESTART_MARGIN = 4
"""Restarts of a worker that the operator may have missed before the agent died."""
_MAX_ENDED_WORKERS = 1000
"""Ended workers that the agent no longer lists and that the operator still remembers."""
_MAX_NEWS = 400
"""Lines of news kept from before the agent restarted."""
_RESUME_TIMEOUT = 5.0
"""Seconds that the run's operator has to resume the run with an agent that restarted."""
_LOST = {"unknown": "the agent was restarted", "timed out": "the agent had ended the run"}
"""Why an agent no longer has the run, by its answer to `FindRun`."""
_TIMEOUT = 2.0
"""Seconds that an agent has to answer."""
_PREPARE_TIMEOUT = 30.0
"""Seconds that an agent may take to start its workers."""


class RemoteHost:
    """`Host` over Zenoh; a thread polls its status and keeps the newest.

    media: local folder whose files the agent has below its own --media folder.
    """

    def __init__(
        self, client: RpcClient, name: str, media: Path = Path(), order: RunOrder | None = None
    ) -> None:
        """client: reaches the agent; order: the order that the agent has already, None before `prepare`."""
        self.name = name
        self.run = "" if order is None else order.run
        self.order = order
        self._client = client
        self._media = media
        self.log = RunLog()
        self._logged = -1
        """The agent's number of the newest log record that has arrived."""
        self._old_news: tuple[str, ...] = ()
        """News from before the agent restarted."""
        self._missing = ""
        """The agent's answer that it has no such run, "" if it has the run."""
        self._stopped = False
        self._status = HostStatus((), ())
        self._heard = self._taken = time.monotonic()
        """Monotonic times, s, of the last answer and of the kept status."""
        self._invalid = ""
        """Why the last answer was invalid, "" if it was valid."""
        self._heartbeat = Heartbeat()
        self._news = threading.Event()
        self._closed = threading.Event()
        self._undelivered: deque[RunRequest] = deque()
        """Orders to deliver when the host answers again."""
        self._standing_orders: list[Relayed] = []
        """Relayed orders to repeat to an agent that restarts."""
        self.ask = self._dispatcher().dispatch
        self._poller = threading.Thread(target=self._poll_until_closed, name=f"status of {name}", daemon=True)

    def prepare(self, order: RunOrder) -> None:
        """Send the plan to the agent, after ending the runs that dead operators of this machine left there.

        Raises FollowspotError if the agent refuses, HostLost if it does not answer.
        """
        self.run = order.run
        own = self._client.own
        order = replace(order, origin=own_origin("" if own == UNPROVEN else own.name))
        for line in end_abandoned_runs(self._client, self.name, order.origin):
            self._old_news += (line,)
            self.log.say("warning", line)
        plan = packed(plan_from_data(order.plan), self.name, self._media)
        self.order = replace(order, plan=plan, out=None)
        self._ask(PrepareRun(order=self.order), _PREPARE_TIMEOUT)
        self.watch()

    def watch(self, *, silent: bool = False) -> None:
        """Start polling the status; return once the first status has arrived.

        silent: True if the host is known not to answer now: return without waiting for a status. Raises
        HostLost if the host does not answer, FollowspotError if it refuses.
        """
        if not silent:
            self._refresh()
        self._poller.start()

    def _dispatcher(self) -> Dispatcher:
        """What becomes of a request on its way to the agent."""
        return Dispatcher(
            "host",
            {
                StartRun: partial(self._send, timeout=_TIMEOUT),
                GetStates: self._send,
                StopRun: self._stop,
                EndWorkers: self._end_workers,
                ChangeOrder: self._change,
                MoveOrder: self._move,
                **dict.fromkeys(RELAYED, self._relay),
            },
        )

    def _send(self, request: RunRequest, timeout: float = _PREPARE_TIMEOUT) -> Any:
        """The agent's answer. Raises HostLost, FollowspotError."""
        return self._ask(request.model_copy(update={"run": self.run}), timeout)

    def _stop(self, request: StopRun) -> None:
        """End the sources, as soon as the host answers."""
        self._stopped = True
        self._deliver(request)

    def _end_workers(self, request: EndWorkers) -> None:
        """Announce workers that have ended, as soon as the host answers."""
        assert self.order is not None
        self.order = replace(self.order, over=request.workers)
        self._deliver(request)

    def _change(self, order: ChangeOrder) -> None:
        """One step of a hot swap; an agent that restarts resumes with the stages as they are then."""
        assert self.order is not None
        stages = packed_stages(order.stages, self._media)
        self._send(order.model_copy(update={"stages": stages}))
        if order.step == "take_over":
            plan = with_stages(plan_from_data(self.order.plan), stages)
            self.order = replace(self.order, plan=plan_to_data(plan))

    def _move(self, order: MoveOrder) -> None:
        """One step of a move; an agent that restarts resumes with the stages as they are then."""
        assert self.order is not None
        plan = order.plan and packed(plan_from_data(order.plan), self.name, self._media)
        self._send(order.model_copy(update={"plan": plan}))
        if plan is not None and not order.trial:
            self.order = replace(self.order, plan=plan)

    def _relay(self, order: Relayed) -> None:
        """Send an order for the workers of the host, as soon as it answers."""
        assert self.order is not None
        plan = plan_from_data(self.order.plan)
        mine = {stage.name for stage in plan.stages if plan.host_of(stage.worker) == self.name}
        order = order.part_for(mine).model_copy(update={"run": self.run})
        self._standing_orders = order.standing(self._standing_orders)
        self._deliver(order)

    def attend(self, timeout: float) -> None:
        """Wait for a new status. Raises HostLost if the heartbeat of the host has stopped."""
        self._news.wait(timeout)
        self._news.clear()
        if self._heartbeat.silent({self.name: self._heard}, time.monotonic()):
            raise HostLost(self._missing or f"host {self.name} does not answer{self._invalid}")

    def status(self) -> HostStatus:
        """The newest status, with its age."""
        status, since = self._status, self._taken
        return status if status.age_s is None else replace(status, age_s=time.monotonic() - since)

    def leave(self) -> None:
        """Stop polling; the run goes on."""
        self._closed.set()
        if self._poller.is_alive():
            self._poller.join()

    def close(self) -> bool:
        """End the run on the host; False if the host does not answer, so that its workers go on."""
        self.leave()
        try:
            self._ask(CloseRun(run=self.run))
        except (HostLost, zenoh.ZError):
            return self.order is None
        except FollowspotError:  # the agent has no such run
            return True
        return True

    def _ask(self, request: Request, timeout: float = _TIMEOUT) -> Any:
        return self._client.ask(self.name, request, timeout)

    def _deliver(self, request: RunRequest) -> None:
        """Send an order now; if the host does not answer, send it again when it does."""
        request = request.model_copy(update={"run": self.run})
        try:
            self._ask(request)
        except HostLost:
            self._undelivered.append(request)
        except FollowspotError:
            return

    def _refresh(self) -> None:
        status: HostStatus = self._read(GetHostStatus(run=self.run), SILENCE)
        self._heard = taken = time.monotonic()
        self._missing = ""
        self._fetch_log(status.logged)  # first: once all workers are seen to be over, polling stops
        here = {worker.name for worker in status.workers}
        over = (w for w in self._status.workers if w.phase == "over" and w.name not in here)
        ended = islice(over, _MAX_ENDED_WORKERS)
        workers, news = (*status.workers, *ended), (*self._old_news, *status.news)
        self._status, self._taken = replace(status, workers=workers, news=news), taken
        self._news.set()

    def _fetch_log(self, newest: int) -> None:
        """Fetch the new log records; an agent that restarted numbers its records from 0 again."""
        self._logged = min(self._logged, newest)
        if newest > self._logged:
            page = self._read(GetLog(run=self.run, after=self._logged))
            self._logged = page.last
            self.log.add(*(replace(record, host=self.name) for record in page.records))

    def _read(self, request: Request, timeout: float = _TIMEOUT) -> Any:
        """The host's answer; keeps the reason if it is invalid. Raises FollowspotError."""
        try:
            found = self._ask(request, timeout)
        except InvalidAnswer as error:
            self._invalid = f"; its last answer was invalid: {error.why}"[:300]
            raise
        self._invalid = ""
        return found

    def _poll_until_closed(self) -> None:
        while not self._closed.wait(_POLL_PERIOD):
            with suppress(FollowspotError, zenoh.ZError):
                self._poll()

    def _poll(self) -> None:
        """Fetch the status, then send the undelivered orders. Raises FollowspotError, ZError."""
        try:
            self._refresh()
        except HostRefused as error:
            self._missing = str(error)
            self._resume()
            return
        while self._undelivered:
            with suppress(HostRefused):
                self._ask(self._undelivered[0])
            self._undelivered.popleft()

    def _end_if_not_resumed(self) -> None:
        """Call the workers over if no other operator has resumed the run in time."""
        if time.monotonic() - self._heard > _RESUME_TIMEOUT:
            workers = tuple(replace(worker, phase="over") for worker in self._status.workers)
            self._status = replace(self._status, workers=workers)
            self._news.set()

    def _resume(self) -> None:
        """Prepare the run again if the agent has lost it, unless the run is to end.

        The link may be cut at any moment, so the later orders are queued until the agent answers.
        """
        order = self.order
        if order is None or (lost := _LOST.get(self._ask(FindRun(run=self.run)))) is None:
            return
        if not order.restart or self._stopped:
            self._end_if_not_resumed()
            return
        incarnations = {w.name: w.restarts + _RESTART_MARGIN for w in self._status.workers}
        self._old_news = (*self._status.news, f"{lost}: its workers start again")[-_MAX_NEWS:]
        after: list[RunRequest] = [*self._standing_orders, StartRun(run=self.run)]
        self._undelivered.extendleft(each for each in reversed(after) if each not in self._undelivered)
        try:
            self._ask(PrepareRun(order=replace(order, incarnations=incarnations)), _PREPARE_TIMEOUT)
        except HostRefused as error:
            self._missing = f"{error}; it cannot resume the run"
