"""Another graph file in the place of a sub-graph, with other stages and edges, while the run goes on.

If all that differs is in one worker, that worker builds what is new, comes to rest, and goes on with the new
plan. Else all workers do so together. No worker starts anew.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING
from uuid import uuid4

from followspot.control.host import Host
from followspot.control.move import MoveOrder
from followspot.control.swap import ChangeOrder
from followspot.errors import FollowspotError
from followspot.graph.change.difference import only_worker
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.operator.change.change_steps import ChangeSteps, HostPart
from followspot.operator.change.joint_rewire import rewire_together
from followspot.operator.change_under_way import GIVEN_UP, OnWait, host_names
from followspot.worker.wiring import Wiring

if TYPE_CHECKING:
    from followspot.operator.coordinator import Coordinator


def rewire(run: Coordinator, new: Plan, *, fresh: bool) -> None:
    """Bring a run from its plan to one with other stages and edges.

    Raises FollowspotError if a host refuses, a stage cannot be built or a worker does not come to rest: the
    run goes on as it was.
    """
    old, data = run.plan, plan_to_data(new)
    order = ChangeOrder(id=uuid4().hex, step="build", stages=(), fresh=fresh, plan=data)
    worker = only_worker(old, new)
    if worker is not None and not _noticing(old, new) - {worker}:
        host = next(found for found in run.hosts if found.name == new.host_of(worker))
        _rewire_alone(host, old, order.model_copy(update={"workers": (worker,)}), run.change.wait_for)
        others = [other for other in run.hosts if other is not host]
    else:
        others = rewire_together(run.hosts, old, new, order, run.change.wait_for)
    for other in others:
        run.change.wait_for(f"{host_names([other.name])} to take the new plan")
        other.ask(MoveOrder(plan=data))


def _rewire_alone(host: Host, old: Plan, order: ChangeOrder, on_wait: OnWait) -> None:
    """Let a worker take the new plan while the others go on. Raises FollowspotError."""
    steps = ChangeSteps([HostPart(host, order)], on_wait)
    steps.build()
    try:
        steps.do("take_over", "done")
    except GIVEN_UP:
        with suppress(FollowspotError):
            host.ask(MoveOrder(plan=plan_to_data(old)))
        raise


def _noticing(old: Plan, new: Plan) -> set[str]:
    """The workers of stages that stay, but wait otherwise than before: joins upstream look ahead further.

    A sink with one input fires for each message as it comes, whatever is upstream.
    """
    before, after = Wiring(old), Wiring(new)
    found: set[str] = set()
    for stage in new.stages:
        name = stage.name
        if name not in before.closing or before.waits(name) == after.waits(name):
            continue
        readers = {new.edge(number).to_stage for number in after.out_of[name]}
        concerned = {one for one in (name, *readers) if after.out_of[one] or len(after.into[one]) > 1}
        found |= {new.worker_of(one) for one in concerned}
    return found
