"""Move on all hosts of a run: the workers that must restart leave first, then start at their new places."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from followspot.control.host import Host, HostLost, WorkerStatus
from followspot.control.move import MOVE_TIMEOUT, MoveOrder
from followspot.control.observation import GetStates
from followspot.errors import FollowspotError
from followspot.graph.change.move import plan_after_move, restarted_workers
from followspot.graph.frame_count import sinks
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.host.heartbeat import SILENCE
from followspot.operator.change_outcome import MoveOutcome
from followspot.operator.change_under_way import GIVEN_UP, OnWait, host_names, no_notice
from followspot.operator.run_requests import MoveStages

if TYPE_CHECKING:
    from followspot.operator.coordinator import Coordinator

_TIMEOUT = 60.0
"""Seconds that workers have to leave, and again to be running."""
_POLL_INTERVAL = 0.02
"""Seconds between two polls of the hosts."""


def move_stages(run: Coordinator, request: MoveStages) -> MoveOutcome:
    """Move stages of a live run to another worker or host. Safe from any thread.

    Workers whose stages or kinds of edges change restart from the state of their stages. Messages in flight
    to and from them are lost and counted. Raises InputError for mistakes in the request, FollowspotError if a
    host refuses, does not answer or a worker cannot start at its new place.
    """
    with run.one_change():
        settle_plans(run)
        new = plan_after_move(
            run.plan, request.stages, request.place, run.others.names() if run.others else ()
        )
        report = MoveOutcome.of(run.name, run.plan, new)
        if report.stages:
            run.join({worker.host for worker in new.workers} - {host.name for host in run.hosts})
            move_hosts(run.plan, new, run.hosts, run.change.wait_for)
            run.plan = replace(new, notes=(*new.notes, f"while it ran: {report.text}"))
        return report


def settle_plans(run: Coordinator) -> None:
    """Bring all hosts to the plan of the run, if some have another since a change was interrupted.

    Raises FollowspotError if they cannot be, or a worker cannot start at its place.
    """
    if (found := run.plan_conflict) is None:
        return
    if not found.curable:
        raise FollowspotError(found.text)
    _replace(found.other, run.plan, run.hosts, found.workers(run.plan), run.change.wait_for)
    run.plan_conflict = None


def move_hosts(old: Plan, new: Plan, hosts: Sequence[Host], on_wait: OnWait = no_notice) -> None:
    """Bring a run from the old plan to the new one. Safe beside the thread that attends the hosts.

    Raises FollowspotError if a host refuses the new plan, before any worker has left; or if a worker cannot
    begin at its new place: then all go back to their old places.
    """
    for host in _each(hosts, "to check the new plan", on_wait):
        host.ask(MoveOrder(plan=plan_to_data(new), trial=True))
    leaving = restarted_workers(old, new)
    try:
        _replace(old, new, hosts, leaving, on_wait)
    except GIVEN_UP as error:
        if left := _go_back(new, old, hosts, leaving, on_wait):
            raise FollowspotError("\n    ".join([str(error) or "interrupted", *left])) from None
        raise


def _go_back(new: Plan, old: Plan, hosts: Sequence[Host], leaving: set[str], on_wait: OnWait) -> list[str]:
    """Bring all workers back to their old places; workers of a silent host start there when it answers.

    Returns what is left to be done, a line each.
    """
    left = []
    try:
        _replace(new, old, hosts, leaving, on_wait, back=True)
    except GIVEN_UP as error:
        left.append(f"on the way back: {str(error) or 'interrupted'}")
    if silent := [host.name for host in hosts if (host.status().age_s or 0.0) > SILENCE]:
        line = f"{host_names(silent)} does not answer: what ran there begins again at its old place"
        left.append(f"{line} within {MOVE_TIMEOUT:.0f} s of its return")
    return left


def _replace(
    old: Plan, new: Plan, hosts: Sequence[Host], leaving: set[str], on_wait: OnWait, *, back: bool = False
) -> None:
    """Let the workers that must restart leave, and start them at their new places.

    A host that gets stages takes the plan before those that lose them: one of the two knows their parameters
    even if the operator dies in between. back: on the way back no host may hold up the others. Raises
    FollowspotError.
    """
    for host in _each(hosts, "to stop its workers", on_wait):
        host.ask(MoveOrder(leaving=tuple(sorted(leaving)), back=back))
    _await_absent(leaving, hosts, on_wait)
    states = _states(old, hosts, on_wait, back=back)
    before = {worker.name: worker.restarts for worker in _workers(hosts)}
    earlier = {host.name: frozenset(host.status().news) for host in hosts}
    own_stages, fired = _own(new), _fired(old, new, hosts)
    arriving = {host for host, _ in own_stages - _own(old)}
    for host in _each(
        sorted(hosts, key=lambda host: host.name not in arriving), "to take the new plan", on_wait
    ):
        own = {stage: state for stage, state in states.items() if (host.name, stage) in own_stages}
        host.ask(MoveOrder(plan=plan_to_data(new), states=own, fired=fired, back=back))
    await_running = _await_back if back else _await_running
    try:
        await_running(leaving & {worker.name for worker in new.workers}, hosts, before, on_wait)
    except FollowspotError as error:
        raise FollowspotError("\n    ".join((str(error), *_faults_since(earlier, hosts)))) from None


def _states(plan: Plan, hosts: Sequence[Host], on_wait: OnWait, *, back: bool) -> dict[str, Any]:
    """The newest checkpoint of each stage: that of its host by the plan, because others may have old ones.

    back: whether to go on without the states of a host that does not answer. Raises HostLost.
    """
    states: dict[str, Any] = {}
    own = _own(plan)
    for host in _each(hosts, "to give the states of its stages", on_wait):
        with suppress(*[HostLost] if back else []):
            for stage, state in host.ask(GetStates()).items():
                if stage not in states or (host.name, stage) in own:
                    states[stage] = state
    return states


def _fired(old: Plan, new: Plan, hosts: Sequence[Host]) -> dict[str, int]:
    """Frames done by the workers of the new plan that have sinks: those of the sinks in their old workers."""
    done = {worker.name: worker.fired for worker in _workers(hosts)}
    before = {stage.name: stage.worker for stage in old.stages}
    found: dict[str, int] = {}
    for sink in sinks(new):
        count = done.get(before.get(sink.name, ""), done.get(sink.worker, 0))
        found[sink.worker] = min(count, found.get(sink.worker, count))
    return found


def _own(plan: Plan) -> set[tuple[str, str]]:
    """Each stage, after its host."""
    return {(plan.host_of(stage.worker), stage.name) for stage in plan.stages}


def _each(hosts: Sequence[Host], doing: str, on_wait: OnWait) -> Iterator[Host]:
    """The hosts, each of which is awaited while it is asked."""
    for host in hosts:
        on_wait(f"{host_names([host.name])} {doing}")
        yield host


def _await_absent(workers: set[str], hosts: Sequence[Host], on_wait: OnWait) -> None:
    """Wait until all these workers are absent, but for those of silent hosts.

    Raises FollowspotError after a timeout.
    """
    for _ in _polls("workers did not leave"):
        heard = [host for host in hosts if (host.status().age_s or 0.0) <= SILENCE]
        there = [w.name for w in _workers(heard) if w.name in workers and w.phase != "absent"]
        if not there:
            return
        on_wait(f"worker {', '.join(there)} to stop")


def _await_running(
    workers: set[str], hosts: Sequence[Host], before: Mapping[str, int], on_wait: OnWait
) -> None:
    """Wait until all these workers run again. Raises FollowspotError if one dies while it starts.

    before: the number of restarts of each worker before the move.
    """
    begun: dict[str, int] = {}
    for _ in _polls("workers did not begin at their new places"):
        there = {worker.name: worker for worker in _workers(hosts) if worker.name in workers}
        fresh = [w for w in there.values() if w.restarts > before.get(w.name, -1)]
        for worker in fresh:
            again = worker.restarts > begun.setdefault(worker.name, worker.restarts)
            if again or worker.phase in ("absent", "over"):
                why = f": {worker.report.error}" if worker.report is not None else ""
                raise FollowspotError(f"worker {worker.name} cannot begin at its new place{why}")
        behind = sorted(workers - {worker.name for worker in fresh if worker.phase == "running"})
        if not behind:
            return
        on_wait(f"worker {', '.join(behind)} to begin")


def _await_back(workers: set[str], hosts: Sequence[Host], before: Mapping[str, int], on_wait: OnWait) -> None:
    """Wait until the workers run at their old places, where one that dies is started again."""
    for _ in _polls("workers did not begin at their old places"):
        fresh = (w for w in _workers(hosts) if w.restarts > before.get(w.name, -1) and w.phase == "running")
        behind = sorted(workers - {worker.name for worker in fresh})
        if not behind:
            return
        on_wait(f"worker {', '.join(behind)} to begin at its old place")


def _faults_since(earlier: Mapping[str, frozenset[str]], hosts: Sequence[Host]) -> Iterator[str]:
    """The first line of each new fault on a host, with the host. earlier: the news of each before."""
    for host in hosts:
        for line in host.status().news:
            if line not in earlier[host.name] and not line.endswith(" is back"):
                yield f"{host.name or 'this host'}: {line.splitlines()[0]}"


def _workers(hosts: Sequence[Host]) -> Iterator[WorkerStatus]:
    return (worker for host in hosts for worker in host.status().workers)


def _polls(problem: str) -> Iterator[None]:
    """Yield once per poll. Raises FollowspotError after a timeout."""
    deadline = time.monotonic() + _TIMEOUT
    while time.monotonic() < deadline:
        yield
        time.sleep(_POLL_INTERVAL)
    raise FollowspotError(f"{problem} within {_TIMEOUT:.0f} s")
