"""Hot swap on all hosts of a run: every host builds the replacements first, then all take over."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING
from uuid import uuid4

from followspot.control.host import Host
from followspot.control.swap import ChangeOrder
from followspot.errors import FollowspotError
from followspot.graph.change.stages import Change, change_of
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.subgraph_use import SubgraphUse
from followspot.operator.change.change_steps import ChangeSteps, HostPart
from followspot.operator.change.move import settle_plans
from followspot.operator.change.rewire import rewire
from followspot.operator.change_outcome import ChangeOutcome, outcome_of_change, with_change
from followspot.operator.change_under_way import GIVEN_UP, OnWait, no_notice
from followspot.operator.run_requests import ChangeStages

if TYPE_CHECKING:
    from followspot.operator.coordinator import Coordinator


def change_stages(run: Coordinator, request: ChangeStages) -> ChangeOutcome:
    """Replace stages and set parameters during the run. Safe from any thread.

    Raises InputError for mistakes in the words, FollowspotError if a replacement cannot be built or cannot
    restore the state of the old stage; the old stages then go on.
    """
    with run.one_change():
        settle_plans(run)
        found = change_of(run.plan, request.words, request.folder)
        report = outcome_of_change(run.name, run.plan, found)
        new = with_change(run.plan, found)
        if found.rewired is not None:
            rewire(run, new, fresh=request.fresh)
        elif found.stages or found.subgraphs != run.plan.subgraphs:
            change_hosts(run.plan, run.hosts, found, fresh=request.fresh, on_wait=run.change.wait_for)
        run.plan = new
        return report


def change_hosts(
    plan: Plan, hosts: Sequence[Host], wanted: Change, *, fresh: bool, on_wait: OnWait = no_notice
) -> None:
    """Replace the stages of the names in `wanted`. Safe beside the thread that attends the hosts.

    Raises FollowspotError with the reason if a replacement cannot be built, cannot restore the state of the
    old stage, or does not take over. The old stages then run again on every host.
    """
    steps = _steps(plan, hosts, wanted.stages, wanted.subgraphs, fresh, on_wait)
    steps.build()
    try:
        steps.do("take_over", "done")
    except GIVEN_UP:
        _undo(plan, hosts, wanted.stages, on_wait)
        raise


def _undo(plan: Plan, hosts: Sequence[Host], stages: Sequence[PlannedStage], on_wait: OnWait) -> None:
    """Let the stages of the plan take over again on each host that answers."""
    names = {stage.name for stage in stages}
    former = [stage for stage in plan.stages if stage.name in names]
    for host in hosts:
        steps = _steps(plan, [host], former, plan.subgraphs, False, on_wait)
        with suppress(FollowspotError):
            steps.build()
            steps.do("take_over", "done")


def _steps(
    plan: Plan,
    hosts: Sequence[Host],
    stages: Sequence[PlannedStage],
    subgraphs: tuple[SubgraphUse, ...],
    fresh: bool,
    on_wait: OnWait,
) -> ChangeSteps:
    """The steps that put these stages in; every host of a run knows all its sub-graphs."""
    known = subgraphs if subgraphs != plan.subgraphs else None
    order = ChangeOrder(id=uuid4().hex, step="build", stages=(), fresh=fresh, subgraphs=known)
    parts = []
    for host in hosts:
        own = tuple(stage for stage in stages if plan.host_of(stage.worker) == host.name)
        if own or known is not None:
            parts.append(HostPart(host, order.model_copy(update={"stages": own})))
    return ChangeSteps(parts, on_wait)
