"""A remote host in a run: the operator asks its agent over Zenoh."""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import zenoh

from followspot.control.dispatch import Request
from followspot.control.host import HostLost, HostRefused, HostStatus, RunOrder
from followspot.control.lifecycle import FindRun
from followspot.control.observation import GetHostStatus, GetLog
from followspot.control.process_identity import own_identity
from followspot.control.zenoh_rpc import InvalidAnswer, RpcClient
from followspot.errors import FollowspotError
from followspot.host.heartbeat import SILENCE, Heartbeat
from followspot.log.run_log import RunLog
from followspot.operator.remote.abandoned_runs import end_abandoned_runs
from followspot.operator.remote.remote_orders import TIMEOUT, RemoteOrders
from followspot.transport.zenoh.network import UNPROVEN

_POLL_PERIOD = 0.2
"""Seconds between two polls of the agent's status."""
_NAME_PERIOD = 5.0
"""Seconds between two looks for another agent of the same name."""
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


class RemoteHost:
    """`Host` over Zenoh; a thread polls its status and keeps the newest.

    media: local folder whose files the agent has below its own --media folder.
    """

    def __init__(
        self, client: RpcClient, name: str, media: Path = Path(), order: RunOrder | None = None
    ) -> None:
        """client: reaches the agent; order: the order that the agent has already, None before `prepare`."""
        self.name = name
        self._client = client
        self._orders = RemoteOrders(client, name, media, order)
        self.ask = self._orders.dispatcher.dispatch
        self.log = RunLog()
        self._logged = -1
        """The agent's number of the newest log record that has arrived."""
        self._old_news: tuple[str, ...] = ()
        """News from before the agent restarted."""
        self._missing = ""
        """The agent's answer that it has no such run, "" if it has the run."""
        self._gone = False
        """Whether the agent has no such run for good."""
        self._status = HostStatus((), ())
        self._heard = self._taken = time.monotonic()
        """Monotonic times, s, of the last answer and of the kept status."""
        self._invalid = ""
        """Why the last answer was invalid, "" if it was valid."""
        self._named, self._has_twin = self._heard, False
        """When another agent of this name was looked for, monotonic time, s, and whether there was one."""
        self._heartbeat = Heartbeat()
        self._news = threading.Event()
        self._closed = threading.Event()
        self._poller = threading.Thread(target=self._poll_until_closed, name=f"status of {name}", daemon=True)

    def prepare(self, order: RunOrder) -> None:
        """Send the plan to the agent, after ending the runs that dead operators of this machine left there.

        Raises FollowspotError if the agent refuses, HostLost if it does not answer.
        """
        own = self._client.own
        order = replace(order, operator=own_identity("" if own == UNPROVEN else own.name))
        for line in end_abandoned_runs(self._client, self.name, order.operator):
            self._old_news += (line,)
            self.log.say("warning", line)
        self._orders.prepare(order)
        self.watch()

    def watch(self, *, silent: bool = False) -> None:
        """Start polling the status; return once the first status has arrived.

        silent: True if the host is known not to answer now: return without waiting for a status. Raises
        HostLost if the host does not answer, FollowspotError if it refuses.
        """
        if not silent:
            self._refresh()
        self._poller.start()

    def attend(self, timeout: float) -> None:
        """Wait for a new status. Raises HostLost if the host has no heartbeat, or no longer has the run."""
        self._news.wait(timeout)
        self._news.clear()
        if self._gone or self._heartbeat.silent({self.name: self._heard}, time.monotonic()):
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
            self._orders.close()
        except (HostLost, zenoh.ZError):
            return self._orders.order is None
        except FollowspotError:  # the agent has no such run
            return True
        return True

    def _refresh(self) -> None:
        status: HostStatus = self._read(GetHostStatus(run=self._orders.run), SILENCE)
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
            page = self._read(GetLog(run=self._orders.run, after=self._logged))
            self._logged = page.last
            self.log.add(*(replace(record, host=self.name) for record in page.records))

    def _read(self, request: Request, timeout: float = TIMEOUT) -> Any:
        """The host's answer; keeps the reason if it is invalid. Raises FollowspotError."""
        try:
            found = self._orders.ask(request, timeout)
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
            if not self._found_twin():  # which may have refused, and must not take the run
                self._resume()
            return
        if time.monotonic() - self._named > _NAME_PERIOD:
            self._found_twin()
        self._orders.deliver()

    def _found_twin(self) -> bool:
        """Whether another agent of this name answers, too; logs when one appears. Raises ZError."""
        self._named = time.monotonic()
        before, self._has_twin = self._has_twin, self._client.has_twins(self.name)
        if self._has_twin and not before:
            remedy = "end the one that was started last"
            self.log.say("warning", f'several agents are named "{self.name}" since the run began: {remedy}')
        return self._has_twin

    def _end_if_not_resumed(self) -> None:
        """Mark all workers as ended if no other operator has resumed the run in time."""
        why = "another operator ended it, or the agent was restarted"
        self._missing = f"host {self.name} no longer has the run: {why}"
        if time.monotonic() - self._heard > _RESUME_TIMEOUT:
            workers = tuple(replace(worker, phase="over") for worker in self._status.workers)
            self._status, self._gone = replace(self._status, workers=workers), True
            self._news.set()

    def _resume(self) -> None:
        """Prepare the run again if the agent has lost it, unless the run is to end."""
        order = self._orders.order
        if order is None or (lost := _LOST.get(self._orders.ask(FindRun(run=order.run)))) is None:
            return
        if not order.restart or self._orders.stopped:
            self._end_if_not_resumed()
            return
        self._old_news = (*self._status.news, f"{lost}: its workers start again")[-_MAX_NEWS:]
        workers = self._status.workers
        incarnations = {worker.name: worker.restarts + _RESTART_MARGIN for worker in workers}
        try:
            self._orders.resume(incarnations, {worker.name: worker.fired for worker in workers})
        except HostRefused as error:
            self._missing = f"{error}; it cannot resume the run"
