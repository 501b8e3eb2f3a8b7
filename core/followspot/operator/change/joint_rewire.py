"""Stages and edges that come and go in several workers of a host, while the sources of all hold.

In a replay they hold at one capture time and everything that they sent is processed, as in one worker. So the
result is that of one worker that changes at this capture time, and nothing is lost. In a live run each worker
finishes what it has, and what is still on its way on an edge that goes is counted as lost.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress
from uuid import uuid4

from followspot.control.host import Host
from followspot.control.swap import ChangeOrder, ChangePhase, Rested, Step
from followspot.errors import FollowspotError, InputError, Mistake
from followspot.graph.change.difference import differing_workers
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data

_TIMEOUT = 60.0
"""Seconds in which a step must be done."""
_BEGIN_TIMEOUT = 5.0
"""Seconds in which workers that start must run."""
_POLL_INTERVAL = 0.01
"""Seconds between two polls of the host."""


def can_rewire_together(old: Plan, new: Plan) -> bool:
    """Whether workers can know when all of them are at rest: they are on one host."""
    hosts = {worker.host for plan in (old, new) for worker in plan.workers}
    return len(hosts) == 1 and not any(edge.kind == "zenoh" for plan in (old, new) for edge in plan.edges)


def check_replay(old: Plan, new: Plan, name: str) -> None:
    """Raise InputError if a replay cannot be rewired. name: of the sub-graph."""
    if not can_rewire_together(old, new):
        text = f'stages of "{name}" come and go in a replay whose workers send over the network'
        remedy = f"run it on one host; or stop it and start it with --set {name}.graph=FILE"
        raise InputError([Mistake(None, text, remedy)])


def rewire_together(host: Host, old: Plan, new: Plan, *, fresh: bool) -> None:
    """Bring the running workers of a host from the old plan to the new one.

    Raises FollowspotError if a stage cannot be built, or a worker has ended or does not come to rest: the run
    goes on as it was.
    """
    running = _running(host)
    if ended := sorted(differing_workers(old, new) - set(running)):
        raise FollowspotError(f"worker {', '.join(ended)} has ended: its stages cannot change")
    change = _JointChange(host, running, new, fresh)
    try:
        change.do("build", "built")
        if old.live:
            change.do(
                "rest", "resting", leaving=tuple(name for group in _leaving(old, new) for name in group)
            )
        else:
            _settle_replay(change, old, new)
    except FollowspotError:
        change.discard()
        raise
    change.do("take_over", "done")
    change.do("go_on", "done")


def _settle_replay(change: _JointChange, old: Plan, new: Plan) -> None:
    """Bring all workers of a replay to rest at one capture time. Raises FollowspotError."""
    held = change.do("hold", "held")
    until = held.time + held.window
    change.settle(until)
    for leaving in _leaving(old, new):
        change.settle(until, leaving)


def _running(host: Host) -> tuple[str, ...]:
    """The workers that run; those that have ended are none. Raises FollowspotError if one stays away."""
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
    """The stages that go, in groups that do not depend on each other; those first that send to others.

    A stage that goes gives what it still has to those after it.
    """
    uses = {stage.name: stage.uses for stage in new.stages}
    gone = [stage.name for stage in old.stages if uses.get(stage.name) != stage.uses]
    rank: dict[str, int] = {}
    for stage in old.stages:  # in topological order
        before = (e.from_stage for e in old.edges if e.to_stage == stage.name and e.from_stage in rank)
        rank[stage.name] = 1 + max((rank[name] for name in before), default=0)
    for level in sorted({rank[name] for name in gone}):
        yield tuple(name for name in gone if rank[name] == level)


class _JointChange:
    """The steps of one change in several workers of a host."""

    def __init__(self, host: Host, workers: tuple[str, ...], plan: Plan, fresh: bool) -> None:
        self._host = host
        self._plan = plan_to_data(plan)
        self._turn = 0
        self._order = ChangeOrder(id=uuid4().hex, step="build", stages=(), fresh=fresh, workers=workers)

    def do(self, step: Step, phase: ChangePhase, until: int = -1, leaving: tuple[str, ...] = ()) -> Rested:
        """Do one step in all workers and wait until it is done. Raises FollowspotError."""
        self._turn += 1
        plan = self._plan if step in ("build", "take_over") else None
        fields = {"step": step, "turn": self._turn, "until": until, "leaving": leaving, "plan": plan}
        self._host.ask(self._order.model_copy(update=fields))
        deadline = time.monotonic() + _TIMEOUT
        while True:
            status = self._host.status()
            mine = (status.change.id, status.change.turn) == (self._order.id, self._turn)
            if mine and status.change.phase == "failed":
                raise FollowspotError(status.change.error)
            if mine and status.change.phase == phase:
                return status.change.rested
            if status.all("over"):
                raise FollowspotError("the run has ended")
            if time.monotonic() > deadline:
                raise FollowspotError(f"the change was not made within {_TIMEOUT:.0f} s")
            time.sleep(_POLL_INTERVAL)

    def settle(self, until: int, leaving: tuple[str, ...] = ()) -> None:
        """Wait until no worker has anything to do and nothing is on its way. Raises FollowspotError.

        Each worker was at rest in two rounds, and did nothing between them: so at the end of the first round
        nothing was on its way to any.
        """
        last = None
        while last != (last := self.do("rest", "resting", until, leaving).activity):
            pass

    def discard(self) -> None:
        """Let the workers go on as they were."""
        self._turn += 1
        with suppress(FollowspotError):
            self._host.ask(self._order.model_copy(update={"step": "discard", "turn": self._turn}))
