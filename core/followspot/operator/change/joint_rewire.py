"""Changes stages and edges in the workers of all hosts while all sources hold.

In a replay the sources hold at one capture time, and all messages that they have sent are processed. So the
result is that of one worker that changes at this capture time, and nothing is lost. In a live run each worker
processes the messages that it has; messages still in flight on an edge that leaves are counted as lost.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence

from followspot.control.host import Host
from followspot.control.swap import ChangeOrder
from followspot.errors import FollowspotError
from followspot.graph.change.difference import differing_workers
from followspot.graph.plan import Plan
from followspot.operator.change.change_steps import ChangeSteps, HostPart
from followspot.operator.change_under_way import GIVEN_UP, OnWait

_BEGIN_TIMEOUT = 5.0
"""Seconds in which workers that start must run."""
_POLL_INTERVAL = 0.01
"""Seconds between two polls of a host."""


def _running_workers(hosts: Sequence[Host], old: Plan, new: Plan) -> Mapping[str, tuple[str, ...]]:
    """The running workers of each host.

    Raises FollowspotError if a worker does not start in time, or if one that would have to change has ended.
    """
    running = {host.name: _running(host) for host in hosts}
    there = {worker for workers in running.values() for worker in workers}
    if ended := sorted(differing_workers(old, new) - there):
        raise FollowspotError(f"worker {', '.join(ended)} has ended: its stages cannot change")
    return running


def rewire_together(
    hosts: Sequence[Host], old: Plan, new: Plan, order: ChangeOrder, on_wait: OnWait
) -> list[Host]:
    """Bring all running workers from the old plan to the new one; returns the hosts without any.

    Raises FollowspotError if a stage cannot be built, or a worker has ended or does not come to rest: the run
    goes on as it was.
    """
    running = _running_workers(hosts, old, new)
    parts = [
        HostPart(host, order.model_copy(update={"workers": running[host.name]}))
        for host in hosts
        if running[host.name]
    ]
    steps = ChangeSteps(parts, on_wait)
    steps.build()
    try:
        if old.live:
            steps.do("rest", "resting", leaving=[name for group in _leaving(old, new) for name in group])
        else:
            _settle_replay(steps, old, new)
    except GIVEN_UP:
        steps.discard()
        raise
    steps.do("take_over", "done")
    steps.do("go_on", "done")
    return [host for host in hosts if not running[host.name]]


def _settle_replay(steps: ChangeSteps, old: Plan, new: Plan) -> None:
    """Bring all workers of a replay to rest at one capture time. Raises FollowspotError."""
    held = steps.do("hold", "held")
    until = held.time + held.window
    _settle(steps, until, ())
    for leaving in _leaving(old, new):
        _settle(steps, until, leaving)


def _settle(steps: ChangeSteps, until: int, leaving: Sequence[str]) -> None:
    """Wait until no worker has anything to do and no message is in flight. Raises FollowspotError.

    That is so after two rounds in which each worker was at rest and between which none did anything: no
    message can have been in flight at the end of the first.
    """
    last = None
    while last != (last := steps.do("rest", "resting", until, leaving).activity):
        pass


def _running(host: Host) -> tuple[str, ...]:
    """The running workers of a host. Raises FollowspotError if a worker does not start in time."""
    deadline = time.monotonic() + _BEGIN_TIMEOUT
    while True:
        workers = host.status().workers
        away = [worker.name for worker in workers if worker.phase not in ("running", "over")]
        if not away:
            return tuple(worker.name for worker in workers if worker.phase == "running")
        if time.monotonic() > deadline:
            raise FollowspotError(f"worker {', '.join(away)} is not running; try again in a moment")
        time.sleep(_POLL_INTERVAL)


def _leaving(old: Plan, new: Plan) -> Iterator[tuple[str, ...]]:
    """The leaving stages in groups, senders before their readers.

    So a stage that leaves sends its remaining messages before its readers leave.
    """
    uses = {stage.name: stage.uses for stage in new.stages}
    gone = [stage.name for stage in old.stages if uses.get(stage.name) != stage.uses]
    rank: dict[str, int] = {}
    for stage in old.stages:  # in topological order
        before = (e.from_stage for e in old.edges if e.to_stage == stage.name and e.from_stage in rank)
        rank[stage.name] = 1 + max((rank[name] for name in before), default=0)
    for level in sorted({rank[name] for name in gone}):
        yield tuple(name for name in gone if rank[name] == level)
