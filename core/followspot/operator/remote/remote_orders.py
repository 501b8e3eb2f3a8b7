"""Orders of a run to a remote host: sent to its agent at once, or when it answers; kept for its restart."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from followspot.control.dispatch import Dispatcher, Request, RunRequest
from followspot.control.host import HostLost, RunOrder
from followspot.control.lifecycle import CloseRun, EndWorkers, PrepareRun, StartRun, StopRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetStates
from followspot.control.plan_transfer import packed, packed_stages
from followspot.control.relay import Relayed
from followspot.control.swap import ChangeOrder
from followspot.control.worker_orders import RELAYED
from followspot.control.zenoh_rpc import RpcClient
from followspot.errors import FollowspotError
from followspot.graph.change.stages import with_stages
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.plugins.code_digest import code_digests, library_versions

TIMEOUT = 2.0
"""Seconds that an agent has to answer."""
_PREPARE_TIMEOUT = 30.0
"""Seconds that an agent may take to start its workers."""


class RemoteOrders:
    """Sends orders to the agent of one host, and keeps what an agent that restarts needs to resume the run.

    host: its name; media: local folder whose files the agent has below its own --media folder; order: the
    order that the agent has already, None before `prepare`.
    """

    def __init__(self, client: RpcClient, host: str, media: Path, order: RunOrder | None) -> None:
        self.order = order
        self.stopped = False
        """Whether the run was told to stop."""
        self._client = client
        self._host = host
        self._media = media
        self._undelivered: deque[RunRequest] = deque()
        """Orders to deliver when the host answers again."""
        self._standing: list[Relayed] = []
        """Relayed orders to repeat to an agent that restarts."""
        self.dispatcher = Dispatcher(
            "host",
            {
                StartRun: partial(self._send, timeout=TIMEOUT),
                GetStates: self._send,
                StopRun: self._stop,
                EndWorkers: self._end_workers,
                ChangeOrder: self._change,
                MoveOrder: self._move,
                **dict.fromkeys(RELAYED, self._relay),
            },
        )

    @property
    def run(self) -> str:
        """Name of the run, "" before `prepare`."""
        return "" if self.order is None else self.order.run

    def ask(self, request: Request, timeout: float = TIMEOUT) -> Any:
        """The agent's answer. Raises HostLost, HostRefused, FollowspotError."""
        return self._client.ask(self._host, request, timeout)

    def prepare(self, order: RunOrder) -> None:
        """Send the plan to the agent. Raises FollowspotError if the agent refuses, HostLost."""
        plan = plan_from_data(order.plan)
        code = code_digests(stage.uses for stage in plan.stages_on(self._host)) | library_versions()
        self.order = replace(order, plan=packed(plan, self._host, self._media), out=None, code=code)
        self.ask(PrepareRun(order=self.order), _PREPARE_TIMEOUT)

    def resume(self, incarnations: Mapping[str, int], fired: Mapping[str, int]) -> None:
        """Prepare the run again, with an agent that has lost it. Raises HostRefused, HostLost.

        incarnations, fired: of its workers, see `RunOrder`. The link may be cut at any moment, so the later
        orders are queued until the agent answers.
        """
        assert self.order is not None
        after: list[RunRequest] = [*self._standing, StartRun(run=self.run)]
        self._undelivered.extendleft(each for each in reversed(after) if each not in self._undelivered)
        order = replace(self.order, incarnations=dict(incarnations), fired=dict(fired))
        self.ask(PrepareRun(order=order), _PREPARE_TIMEOUT)

    def deliver(self) -> None:
        """Send the undelivered orders. Raises HostLost."""
        while self._undelivered:
            try:
                self.ask(self._undelivered[0])
            except HostLost:
                raise
            except FollowspotError:  # an order that the agent cannot answer would hold up those behind it
                pass
            self._undelivered.popleft()

    def close(self) -> None:
        """End the run on the host. Raises HostLost, FollowspotError."""
        self.ask(CloseRun(run=self.run))

    def _send(self, request: RunRequest, timeout: float = _PREPARE_TIMEOUT) -> Any:
        """The agent's answer about the run. Raises HostLost, FollowspotError."""
        return self.ask(request.model_copy(update={"run": self.run}), timeout)

    def _deliver(self, request: RunRequest) -> None:
        """Send an order now; if the host does not answer, send it again when it does."""
        request = request.model_copy(update={"run": self.run})
        try:
            self.ask(request)
        except HostLost:
            self._undelivered.append(request)
        except FollowspotError:
            return

    def _stop(self, request: StopRun) -> None:
        self.stopped = True
        self._deliver(request)

    def _end_workers(self, request: EndWorkers) -> None:
        assert self.order is not None
        self.order = replace(self.order, over=request.workers)
        self._deliver(request)

    def _change(self, order: ChangeOrder) -> None:
        """One step of a hot swap; an agent that restarts resumes with the stages as they are then."""
        assert self.order is not None
        if order.step == "discard":
            self._deliver(order)
            return
        if order.plan is not None:
            data = packed(plan_from_data(order.plan), self._host, self._media)
            self._send(order.model_copy(update={"plan": data}))
            self.order = replace(self.order, plan=data) if order.step == "take_over" else self.order
            return
        stages = packed_stages(order.stages, self._media)
        self._send(order.model_copy(update={"stages": stages}))
        if order.step == "take_over" and not order.workers:
            plan = with_stages(plan_from_data(self.order.plan), stages, order.subgraphs)
            self.order = replace(self.order, plan=plan_to_data(plan))

    def _move(self, order: MoveOrder) -> None:
        """One step of a move; an agent that restarts resumes with the stages as they are then."""
        assert self.order is not None
        plan = order.plan and packed(plan_from_data(order.plan), self._host, self._media)
        (self._deliver if order.back else self._send)(order.model_copy(update={"plan": plan}))
        if plan is not None and not order.trial:
            self.order = replace(self.order, plan=plan)

    def _relay(self, order: Relayed) -> None:
        """Send the part of an order that concerns the workers of the host, as soon as it answers."""
        assert self.order is not None
        plan = plan_from_data(self.order.plan)
        mine = {stage.name for stage in plan.stages_on(self._host)}
        order = order.part_for(mine).model_copy(update={"run": self.run})
        self._standing = order.standing(self._standing)
        self._deliver(order)
