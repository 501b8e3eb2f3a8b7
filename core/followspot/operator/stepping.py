"""A step of a paused replay: every source sends up to a capture time, then holds again."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import Protocol
from uuid import uuid4

from followspot.control.dispatch import Ask, NoAnswer
from followspot.control.stage_status import StageStatus
from followspot.control.worker_orders import HoldSources
from followspot.errors import FollowspotError, InputError
from followspot.graph.plan import Plan
from followspot.operator.run_status import RunStatus

_TIMEOUT = 10.0
"""Seconds that the run has to take an order."""
_STALLED = 60.0
"""Seconds without a message of any source after which a step fails."""
_POLL_INTERVAL = 0.02
"""Seconds between two polls of the sources."""
_REPEAT_INTERVAL = 1.0
"""Seconds after which the order is sent again: the run refuses it if another command has held the sources or
let them go on."""


class Steps(Protocol):
    """The part of a handle on a run that stepping needs."""

    ask: Ask

    def plan(self) -> Plan:
        """The plan as it is now."""

    def status(self) -> RunStatus:
        """The status of the run now. Raises FollowspotError if it has ended."""


def step(run: Steps, count: int, source: str | None) -> int:
    """Let a replay go on for the next `count` capture times of a source; see `RunHandle.step`."""
    if count < 0:
        raise InputError.of(f"count is {count}", "give a whole number from 0")
    plan = run.plan()
    fed = {edge.to_stage for edge in plan.edges}
    sources = [stage for stage in plan.stages if stage.name not in fed]
    chosen = source or min(sources, key=lambda stage: stage.camera is None).name
    order = HoldSources(id=uuid4().hex, source=chosen, count=count)
    run.ask(order, _TIMEOUT)
    names, times, deadline = {stage.name for stage in sources}, None, 0.0
    repeat = time.monotonic() + _REPEAT_INTERVAL
    while True:
        found = _statuses(run, names)
        if found is None:
            return order.until
        late = time.monotonic() > repeat
        reached = max(order.until, found[chosen].time if chosen in found else -1, 0 if late else -1)
        if reached > order.until or late:
            order = order.model_copy(update={"until": reached})
            run.ask(order, _TIMEOUT)
            repeat = time.monotonic() + _REPEAT_INTERVAL
        if names == found.keys() and all(_has_stepped(stage, order) for stage in found.values()):
            return order.until
        if times != (times := {stage.stage: stage.time for stage in found.values()}):
            deadline = time.monotonic() + _STALLED
        if time.monotonic() > deadline:
            raise NoAnswer(f"no source has sent anything for {_STALLED:.0f} s")
        time.sleep(_POLL_INTERVAL)


def _statuses(run: Steps, names: Collection[str]) -> dict[str, StageStatus] | None:
    """The status of these stages; None if the run has ended."""
    try:
        workers = run.status().workers
    except NoAnswer:
        raise
    except FollowspotError:
        return None
    stages = (stage for worker in workers for stage in worker.stages)
    return {stage.stage: stage for stage in stages if stage.stage in names}


def _has_stepped(source: StageStatus, order: HoldSources) -> bool:
    """True if a source has sent all messages that the order allows."""
    if source.state == "over":
        return True
    return source.state == "paused" and source.hold == order.id and source.time >= order.until
