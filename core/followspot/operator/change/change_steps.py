"""The steps of a change on all hosts of a run: each is done everywhere before the next begins."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from followspot.control.host import Host, HostLost
from followspot.control.swap import ChangeOrder, ChangePhase, Rested, Step
from followspot.errors import FollowspotError
from followspot.operator.change_under_way import GIVEN_UP, OnWait, host_names, no_notice

_TIMEOUT = 60.0
"""Seconds in which a step must be done: some stages load models."""
_DISCARD_TIMEOUT = 5.0
"""Seconds that hosts have to close the new stages, before the user is told why the change failed."""
_POLL_INTERVAL = 0.01
"""Seconds between two polls of the hosts."""
_NO_WAY_BACK: tuple[Step, ...] = ("take_over", "go_on")
"""Steps that a host must do once another has begun."""
_DOING: Mapping[Step, str] = {
    "build": "build the new stages",
    "hold": "hold the sources",
    "rest": "come to rest",
    "take_over": "let the new stages take over",
    "go_on": "go on",
    "discard": "close the new stages",
}


@dataclass(frozen=True)
class HostPart:
    """The part of one host in a change. order: the common fields of the orders of all steps."""

    host: Host
    order: ChangeOrder

    def pass_on(self, fields: Mapping[str, Any], deadline: float) -> None:
        """Pass a step on; again if the host does not answer, if there is no way back. Raises FollowspotError.

        deadline: s, monotonic.
        """
        order = self.order.model_copy(update=fields)
        while True:
            try:
                self.host.ask(order)
            except HostLost:
                if order.step not in _NO_WAY_BACK or time.monotonic() > deadline:
                    raise
                time.sleep(_POLL_INTERVAL)
            else:
                return

    def answer(self, turn: int, phase: ChangePhase) -> Rested | None:
        """The answers of this host's workers when a step is done; None before. Raises FollowspotError."""
        status = self.host.status()
        mine = (status.change.id, status.change.turn) == (self.order.id, turn)
        if mine and status.change.phase == "failed":
            raise FollowspotError(status.change.error)
        if mine and status.change.phase == phase:
            return status.change.rested
        if status.all("over"):
            raise FollowspotError("the run has ended")
        return None


class ChangeSteps:
    """Leads a change through its steps. parts: of the hosts that take part."""

    def __init__(self, parts: Sequence[HostPart], on_wait: OnWait = no_notice) -> None:
        self._parts = parts
        self._on_wait = on_wait
        self._turn = 0

    def do(self, step: Step, phase: ChangePhase, until: int = -1, leaving: Sequence[str] = ()) -> Rested:
        """Do one step on all hosts and wait until it is done; returns the state of the workers.

        until, leaving: see `ChangeOrder`. Raises FollowspotError.
        """
        deadline = self._begin(_TIMEOUT)
        for part in self._parts:
            self._await(step, [part])
            part.pass_on(self._fields(step, part, until=until, leaving=tuple(leaving)), deadline)
        return self._wait_for(step, phase, deadline)

    def build(self) -> None:
        """Let all hosts build the new stages. If one fails, discards them all and raises FollowspotError."""
        try:
            self.do("build", "built")
        except GIVEN_UP:
            self.discard()
            raise

    def discard(self) -> None:
        """Let the workers go on as they were, and wait until the new stages are closed.

        A host that does not answer closes it when it does.
        """
        deadline = self._begin(_DISCARD_TIMEOUT)
        for part in self._parts:
            self._await("discard", [part])
            with suppress(FollowspotError):
                part.pass_on(self._fields("discard", part), deadline)
        with suppress(FollowspotError):
            self._wait_for("discard", "done", deadline)

    def _begin(self, timeout: float) -> float:
        """Begin the next step; returns when it must be done, s, monotonic."""
        self._turn += 1
        return time.monotonic() + timeout

    def _fields(self, step: Step, part: HostPart, **fields: Any) -> dict[str, Any]:
        plan = part.order.plan if step in ("build", "take_over") else None
        return {**fields, "step": step, "turn": self._turn, "plan": plan}

    def _await(self, step: Step, parts: Sequence[HostPart]) -> None:
        self._on_wait(f"{host_names(part.host.name for part in parts)} to {_DOING[step]}")

    def _wait_for(self, step: Step, phase: ChangePhase, deadline: float) -> Rested:
        """Wait until all hosts have done the step. Raises FollowspotError."""
        while True:
            answers = [part.answer(self._turn, phase) for part in self._parts]
            found = [answer for answer in answers if answer is not None]
            if len(found) == len(self._parts):
                return Rested.of(found)
            behind = [part for part, answer in zip(self._parts, answers, strict=True) if answer is None]
            self._await(step, behind)
            if time.monotonic() > deadline:
                raise FollowspotError(f"the change was not made within {_TIMEOUT:.0f} s")
            time.sleep(_POLL_INTERVAL)
