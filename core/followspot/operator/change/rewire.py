"""Another graph file in the place of a sub-graph, with other stages and edges, while the run goes on.

If all that differs is in one worker, that worker builds what is new, comes to rest, and goes on with the new
plan: nothing is lost. So do all workers of one host together. In a live run over several hosts, the workers
that differ restart with the new plan, as in a move, once the stages that come were set up on trial.
"""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from followspot.control.host import Host
from followspot.control.move import MoveOrder
from followspot.control.swap import ChangeOrder, ChangePhase
from followspot.errors import FollowspotError
from followspot.graph.change.difference import differing_stages, differing_workers, only_worker, workers_of
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.operator.change.joint_rewire import can_rewire_together, check_replay, rewire_together
from followspot.operator.change.move import move_hosts
from followspot.worker.wiring import Wiring

if TYPE_CHECKING:
    from followspot.operator.coordinator import Coordinator

_TIMEOUT = 60.0
"""Seconds in which new stages must be built, and again to take over."""
_POLL_INTERVAL = 0.01
"""Seconds between two polls of the host."""


def rewire(run: Coordinator, new: Plan, name: str, *, fresh: bool) -> None:
    """Bring a run from its plan to one with other stages and edges. name: of the sub-graph, for messages.

    Raises InputError if it is a replay over several hosts in which more than one worker would have to change,
    FollowspotError if a host refuses or a stage cannot be built: the run goes on as it was.
    """
    old = run.plan
    worker = only_worker(old, new)
    if worker is not None and not _others_notice(old, new, worker):
        _in_place(run, new, worker, fresh=fresh)
        return
    if not old.live:
        check_replay(old, new, name)
    if can_rewire_together(old, new):
        host = next(found for found in run.hosts if found.name == new.workers[0].host)
        rewire_together(host, old, new, fresh=fresh)
        _tell_others(run, host, plan_to_data(new))
        return
    _try_out(run, new)
    move_hosts(old, new, run.hosts, differing_workers(old, new) | _noticing(old, new), fresh=fresh)


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


def _others_notice(old: Plan, new: Plan, worker: str) -> bool:
    return bool(_noticing(old, new) - {worker})


def _in_place(run: Coordinator, new: Plan, worker: str, *, fresh: bool) -> None:
    """Let the worker take the new plan while it works; then tell the other hosts."""
    host = next(found for found in run.hosts if found.name == new.host_of(worker))
    data = plan_to_data(new)
    identity = uuid4().hex

    def order(step: str) -> ChangeOrder:
        return ChangeOrder.model_validate(
            {"id": identity, "step": step, "stages": (), "fresh": fresh, "workers": (worker,), "plan": data}
        )

    try:
        _step(host, order("build"), "built")
    except FollowspotError:
        with suppress(FollowspotError):
            host.ask(order("discard"))
        raise
    try:
        _step(host, order("take_over"), "done")
    except FollowspotError:
        with suppress(FollowspotError):
            host.ask(MoveOrder(plan=plan_to_data(run.plan)))
        raise
    _tell_others(run, host, data)


def _try_out(run: Coordinator, new: Plan) -> None:
    """Let the workers set up the stages that come, beside those that work. Raises FollowspotError."""
    workers = workers_of(new, differing_stages(run.plan, new))
    data = plan_to_data(new)
    for host in run.hosts:
        own = tuple(sorted(name for name in workers if new.host_of(name) == host.name))
        if own:
            order = ChangeOrder(id=uuid4().hex, step="try", stages=(), workers=own, plan=data)
            _step(host, order, "done")


def _tell_others(run: Coordinator, host: Host, plan: dict[str, Any]) -> None:
    """Let the hosts without a part in the change know the new plan."""
    for other in run.hosts:
        if other is not host:
            other.ask(MoveOrder(plan=plan))


def _step(host: Host, order: ChangeOrder, phase: ChangePhase) -> None:
    """Do one step and wait until it is done. Raises FollowspotError."""
    host.ask(order)
    deadline = time.monotonic() + _TIMEOUT
    while True:
        status = host.status()
        mine = status.change.id == order.id
        if mine and status.change.phase == "failed":
            raise FollowspotError(status.change.error)
        if mine and status.change.phase == phase:
            return
        if status.all("over"):
            raise FollowspotError("the run has ended")
        if time.monotonic() > deadline:
            raise FollowspotError(f"the change was not made within {_TIMEOUT:.0f} s")
        time.sleep(_POLL_INTERVAL)
