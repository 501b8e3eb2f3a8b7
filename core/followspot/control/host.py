"""What the operator's side and a host say to each other about a run: orders one way, a status the other.

All of it is plain data. The status is a picture of the whole, not a stream of events: whoever missed one,
or comes later, has nothing to catch up on.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from followspot.control.clock_status import ClockStatus
from followspot.control.move import MoveOrder
from followspot.control.origin import Origin
from followspot.control.relay import Relayed
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.swap import ChangeOrder, ChangeStatus
from followspot.control.worker_report import WorkerReport
from followspot.errors import FollowspotError
from followspot.log.run_log import RunLog
from followspot.ranges import Age, Count, Incarnation, Last, Nanoseconds

WorkerPhase = Literal["starting", "ready", "running", "absent", "over"]
"""absent: it died and will be started again, or its host does not answer; over: it has ended."""


@dataclass(frozen=True)
class RunOrder:
    """Everything that a host must know to prepare its part of a run.

    run: a name that keeps runs apart; plan: as `plan_to_data` gives it; frames: messages per source, None for
    all; out: folder for outputs, None where the host is to choose one; restart: whether workers that die are
    started again; detached: whether it goes on without an operator; incarnations: of workers that were
    started before, under an agent that is gone; over: workers, here or elsewhere, that have ended for good;
    reference: host by whose clock the run goes, whoever joins or leaves later, "" where it began without any
    that has an agent; origin: the process that operates it.
    """

    run: str
    plan: dict[str, Any]
    frames: Count | None = None
    out: str | None = None
    restart: bool = False
    detached: bool = False
    incarnations: dict[str, Incarnation] = field(default_factory=dict)
    over: tuple[str, ...] = ()
    reference: str = ""
    origin: Origin = Origin()

    def here(self, plan: dict[str, Any], out: str) -> RunOrder:
        """The order with the plan and the folder of this host."""
        return replace(self, plan=plan, out=out)


@dataclass(frozen=True)
class WorkerStatus:
    """One worker: how far it is, how often it was started again, and in the end its report.

    age_s: None where it was never heard; host: name of its host, "" for the operator's own.
    """

    name: str
    phase: WorkerPhase
    fired: Count = 0
    time: Nanoseconds = -1
    """Newest capture time that a source sent, ns; -1 before the first."""
    expected: Count | None = None
    restarts: Incarnation = 0
    report: WorkerReport | None = None
    stages: tuple[StageStatus, ...] = ()
    paths: tuple[PathStatus, ...] = ()
    age_s: Age | None = None
    host: str = ""


@dataclass(frozen=True)
class HostStatus:
    """A host's part of a run.

    counts: the words of its ledger, of all edges of the plan; news: what went wrong and what was done about
    it, oldest first; out: where its outputs are; change: the newest one to its stages;
    clock: how it differs from that of the others; logged: number of its newest log record; age_s: None
    before the host was heard for the first time.
    """

    workers: tuple[WorkerStatus, ...]
    counts: tuple[Count, ...]
    news: tuple[str, ...] = ()
    out: str = ""
    change: ChangeStatus = ChangeStatus()
    clock: ClockStatus = ClockStatus()
    logged: Last = -1
    age_s: Age | None = None

    def all(self, *phases: WorkerPhase) -> bool:
        """Whether every worker is in one of these phases."""
        return all(worker.phase in phases for worker in self.workers)


class HostLost(FollowspotError):
    """The host does not answer."""


class HostRefused(FollowspotError):
    """The host answers that it does not do what it was asked; the text says which host, and why."""


class Host(Protocol):
    """One host's part of one run, near or far."""

    name: str
    log: RunLog
    """What workers there say, and what becomes of them."""

    def prepare(self, order: RunOrder) -> None:
        """Start the workers, to wait for each other and for `start`. Raises FollowspotError."""

    def start(self) -> None:
        """All hosts are ready: begin."""

    def stop(self) -> None:
        """End the sources; what is in flight is finished."""

    def ended(self, workers: Sequence[str]) -> None:
        """These workers, here or elsewhere, have come to their end: nobody need wait for them."""

    def change(self, order: ChangeOrder) -> None:
        """One step of a change; what becomes of it stands in the status. Raises FollowspotError."""

    def move(self, order: MoveOrder) -> None:
        """One step of a move. Raises FollowspotError."""

    def states(self) -> dict[str, Any]:
        """What the stages here last told of their state, by stage. Raises FollowspotError."""

    def relay(self, order: Relayed) -> None:
        """Tell the workers that are there, and those that begin later."""

    def attend(self, timeout: float) -> None:
        """Look after the workers for up to `timeout`, s, or wait for news of them. Raises HostLost."""

    def status(self) -> HostStatus:
        """The newest picture there is."""

    def close(self) -> bool:
        """Leave nothing behind: what still lives is killed. False where the host does not answer."""


class Others(Protocol):
    """Hosts in reach of a run that have no part in it yet."""

    def names(self) -> Collection[str]:
        """Of all hosts whose agents are there."""

    def host(self, name: str) -> Host:
        """One of them, to be prepared."""
