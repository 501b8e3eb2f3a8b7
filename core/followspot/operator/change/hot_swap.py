"""Hot swap on all hosts of a run: every host builds the replacements first, then all take over."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING
from uuid import uuid4

from followspot.control.host import Host
from followspot.control.swap import ChangeOrder, ChangePhase, Step
from followspot.errors import FollowspotError
from followspot.graph.change.stages import Change, change_of
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.subgraph_use import SubgraphUse
from followspot.operator.change.rewire import rewire
from followspot.operator.changed import Changed, changed, with_change
from followspot.operator.run_requests import ChangeStages

if TYPE_CHECKING:
    from followspot.operator.coordinator import Coordinator

_TIMEOUT = 60.0
"""Seconds that replacements have to be built: some load models."""
_POLL_INTERVAL = 0.01
"""Seconds between two polls of the hosts."""


def change_stages(run: Coordinator, request: ChangeStages) -> Changed:
    """Replace stages and set parameters during the run. Safe from any thread.

    Raises InputError for mistakes in the words, FollowspotError if a replacement cannot be built or cannot
    restore the state of the old stage; the old stages then go on.
    """
    with run.one_change():
        found = change_of(run.plan, request.words, request.folder)
        report = changed(run.name, run.plan, found)
        new = with_change(run.plan, found)
        if found.rewired is not None:
            rewire(run, new, request.words[0].partition("=")[0], fresh=request.fresh)
        elif found.stages or found.subgraphs != run.plan.subgraphs:
            change_hosts(run.plan, run.hosts, found, fresh=request.fresh)
        run.plan = new
        return report


def change_hosts(plan: Plan, hosts: Sequence[Host], wanted: Change, *, fresh: bool) -> None:
    """Replace the stages of the names in `wanted`. Safe beside the thread that attends the hosts.

    Raises FollowspotError with the reason if a replacement cannot be built, cannot restore the state of the
    old stage, or does not take over. The old stages then run again on every host.
    """
    change = _Change(plan, hosts, wanted.stages, wanted.subgraphs, fresh)
    try:
        change.do("build", "built")
    except FollowspotError:
        change.discard()
        raise
    try:
        change.do("take_over", "done")
    except FollowspotError:
        _undo(plan, hosts, wanted.stages)
        raise


def _undo(plan: Plan, hosts: Sequence[Host], stages: Sequence[PlannedStage]) -> None:
    """Let the stages of the plan take over again on each host that answers."""
    names = {stage.name for stage in stages}
    former = [stage for stage in plan.stages if stage.name in names]
    for host in hosts:
        change = _Change(plan, [host], former, plan.subgraphs, fresh=False)
        with suppress(FollowspotError):
            change.do("build", "built")
            change.do("take_over", "done")


class _Change:
    def __init__(
        self,
        plan: Plan,
        hosts: Sequence[Host],
        stages: Sequence[PlannedStage],
        subgraphs: tuple[SubgraphUse, ...],
        fresh: bool,
    ) -> None:
        self.id = uuid4().hex
        self.fresh = fresh
        self.replacements: Mapping[str, tuple[PlannedStage, ...]] = {
            host.name: tuple(stage for stage in stages if plan.host_of(stage.worker) == host.name)
            for host in hosts
        }
        self.subgraphs = subgraphs if subgraphs != plan.subgraphs else None
        """Every host of a run knows all its sub-graphs."""
        self.hosts = [host for host in hosts if self.subgraphs is not None or self.replacements[host.name]]

    def do(self, step: Step, phase: ChangePhase) -> None:
        """Do one step on all hosts and wait until it is done. Raises FollowspotError."""
        for host in self.hosts:
            host.ask(self._order(host, step))
        deadline = time.monotonic() + _TIMEOUT
        waiting = list(self.hosts)
        while waiting:
            waiting = [host for host in waiting if not self._is_done(host, phase)]
            if waiting and time.monotonic() > deadline:
                raise FollowspotError(f"the change was not made within {_TIMEOUT:.0f} s")
            time.sleep(_POLL_INTERVAL)

    def discard(self) -> None:
        """Discard the replacements."""
        for host in self.hosts:
            with suppress(FollowspotError):
                host.ask(self._order(host, "discard"))

    def _is_done(self, host: Host, phase: ChangePhase) -> bool:
        """True once the host has done the step. Raises FollowspotError if it cannot do it."""
        status = host.status()
        if status.change.id == self.id and status.change.phase == "failed":
            raise FollowspotError(status.change.error)
        done = status.change.id == self.id and status.change.phase == phase
        if not done and status.all("over"):
            raise FollowspotError("the run has ended")
        return done

    def _order(self, host: Host, step: Step) -> ChangeOrder:
        return ChangeOrder(
            id=self.id,
            step=step,
            stages=self.replacements[host.name],
            fresh=self.fresh,
            subgraphs=self.subgraphs,
        )
