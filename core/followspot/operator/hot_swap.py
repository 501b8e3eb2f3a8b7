"""A change on all hosts of a run: built everywhere first, then put in everywhere."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from uuid import uuid4

from followspot.control.host import Host
from followspot.control.swap import ChangeOrder, ChangePhase, Step
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan, PlannedStage

_TIMEOUT = 60.0
"""Seconds that successors may take to be built: some load models."""
_POLL_INTERVAL = 0.01
"""Seconds between two looks."""


def change_hosts(plan: Plan, hosts: Sequence[Host], stages: Sequence[PlannedStage], *, fresh: bool) -> None:
    """Let these stages take the place of those of their names. Safe beside the thread that attends the hosts.

    Raises FollowspotError with the reason where a successor cannot be built or cannot carry on. Where one
    that was built does not take over, those that have done so give their places back.
    """
    change = _Change(plan, hosts, stages, fresh)
    try:
        change.do("build", "built")
    except FollowspotError:
        change.give_up()
        raise
    try:
        change.do("take_over", "done")
    except FollowspotError:
        _undo(plan, hosts, stages)
        raise


def _undo(plan: Plan, hosts: Sequence[Host], stages: Sequence[PlannedStage]) -> None:
    """The stages of the plan take over again, on each host that can be reached."""
    names = {stage.name for stage in stages}
    former = [stage for stage in plan.stages if stage.name in names]
    for host in hosts:
        change = _Change(plan, [host], former, fresh=False)
        with suppress(FollowspotError):
            change.do("build", "built")
            change.do("take_over", "done")


class _Change:
    def __init__(
        self, plan: Plan, hosts: Sequence[Host], stages: Sequence[PlannedStage], fresh: bool
    ) -> None:
        self.id = uuid4().hex
        self.fresh = fresh
        self.parts: Mapping[str, tuple[PlannedStage, ...]] = {
            host.name: tuple(stage for stage in stages if plan.host_of(stage.worker) == host.name)
            for host in hosts
        }
        self.hosts = [host for host in hosts if self.parts[host.name]]

    def do(self, step: Step, phase: ChangePhase) -> None:
        """One step on all hosts, to its end. Raises FollowspotError."""
        for host in self.hosts:
            host.change(self._order(host, step))
        deadline = time.monotonic() + _TIMEOUT
        waiting = list(self.hosts)
        while waiting:
            waiting = [host for host in waiting if not self._reached(host, phase)]
            if waiting and time.monotonic() > deadline:
                raise FollowspotError(f"the change was not made within {_TIMEOUT:.0f} s")
            time.sleep(_POLL_INTERVAL)

    def give_up(self) -> None:
        """What was built is not needed."""
        for host in self.hosts:
            with suppress(FollowspotError):
                host.change(self._order(host, "give_up"))

    def _reached(self, host: Host, phase: ChangePhase) -> bool:
        """Whether the host has done the step. Raises FollowspotError where it cannot."""
        status = host.status()
        if status.change.id == self.id and status.change.phase == "failed":
            raise FollowspotError(status.change.error)
        reached = status.change.id == self.id and status.change.phase == phase
        if not reached and status.all("over"):
            raise FollowspotError("the run has ended")
        return reached

    def _order(self, host: Host, step: Step) -> ChangeOrder:
        return ChangeOrder(id=self.id, step=step, stages=self.parts[host.name], fresh=self.fresh)
