"""A move on all hosts of a run: who must begin anew leaves everywhere, then all take their new places."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from followspot.deploy.changes.move_order import MoveOrder
from followspot.deploy.host import Host
from followspot.errors import FollowspotError
from followspot.graph.move import anew, host_workers
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_to_data

_PATIENCE = 60.0
"""Seconds that workers may take to leave, and to be there again."""
_GLANCE = 0.02
"""Seconds between two looks."""


def move_hosts(old: Plan, new: Plan, hosts: Sequence[Host]) -> None:
    """Bring a run from one plan to the other. Safe beside the thread that attends the hosts.

    Raises FollowspotError where a host refuses its new part; then all go back to their old places.
    """
    leaving = anew(old, new)
    for host in hosts:
        host.move(MoveOrder(tuple(w.name for w in host_workers(old, host.name) if w.name in leaving)))
    _wait(hosts, leaving & {worker.name for worker in old.workers}, "absent")
    states = {stage: state for host in hosts for stage, state in host.states().items()}
    try:
        _settle(new, hosts, states)
    except FollowspotError:
        _settle(old, hosts, states)
        raise
    _wait(hosts, leaving & {worker.name for worker in new.workers}, "running")


def _settle(plan: Plan, hosts: Sequence[Host], states: Mapping[str, Any]) -> None:
    home = {stage.name: stage.worker for stage in plan.stages}
    for host in hosts:
        mine = {worker.name for worker in host_workers(plan, host.name)}
        own = {stage: state for stage, state in states.items() if home[stage] in mine}
        host.move(MoveOrder((), plan_to_data(plan), own))


def _wait(hosts: Sequence[Host], workers: set[str], phase: str) -> None:
    """Until these workers are in this phase. Raises FollowspotError."""
    deadline = time.monotonic() + _PATIENCE
    while True:
        found = {w.name: w.phase for host in hosts for w in host.status().workers if w.name in workers}
        waiting = sorted(name for name in workers if found.get(name) != phase)
        if not waiting:
            return
        if time.monotonic() > deadline or "over" in found.values():
            raise FollowspotError(f"worker {waiting[0]} is {found.get(waiting[0], 'gone')}, not {phase}")
        time.sleep(_GLANCE)
