"""The interface of a host for the operator: the order of a run, and the status of its workers.

Both are plain data. A status is complete, not a difference: an operator that missed one, or joined late,
needs no other.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from followspot.control.clock_status import ClockStatus
from followspot.control.dispatch import RunRequest
from followspot.control.process_identity import ProcessIdentity
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.swap import ChangeStatus
from followspot.control.worker_report import WorkerReport
from followspot.errors import FollowspotError
from followspot.log.run_log import RunLog
from followspot.ranges import Age, Count, Incarnation, Last, Nanoseconds

WorkerPhase = Literal["starting", "ready", "running", "absent", "over"]
"""absent: the worker died and will be restarted, or its host does not answer; over: it has ended for good."""


@dataclass(frozen=True)
class RunOrder:
    """Everything that a host needs to prepare a run.

    run: unique name; plan: as `plan_to_data` gives it; frames: of each camera, None for all; out: folder
    for outputs, None if the host chooses one; restart: whether hosts restart workers that die; detached:
    whether the run goes on without an operator; incarnations: of workers that ran under an earlier agent;
    fired: frames that they did there; age_s: how long the run went on there, s; over: workers of any host
    that have ended for good; reference: the run's reference host, which stays the same when hosts join or
    leave, "" if the run began without agents; operator: its process; code: digests of the packages and
    files that have the stages of the host, as the operator has them.
    """

    run: str
    plan: dict[str, Any]
    frames: Count | None = None
    out: str | None = None
    restart: bool = False
    detached: bool = False
    incarnations: dict[str, Incarnation] = field(default_factory=dict)
    fired: dict[str, Count] = field(default_factory=dict)
    age_s: Age = 0.0
    over: tuple[str, ...] = ()
    reference: str = ""
    operator: ProcessIdentity = ProcessIdentity()
    code: dict[str, str] = field(default_factory=dict)

    def here(self, plan: dict[str, Any], out: str) -> RunOrder:
        """The order with the plan and the folder of this host."""
        return replace(self, plan=plan, out=out)


@dataclass(frozen=True)
class WorkerStatus:
    """The status of one worker.

    phase: see `WorkerPhase`; fired: frames done, also before restarts; expected: frames to be done, None if
    unknown; restarts: how often the worker was restarted; report: None until it has ended; stages, paths:
    their newest statuses; age_s: time since its last message, s, None if there was none; host: its host, ""
    for the operator's own.
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
    stages_age_s: Age | None = None
    """Time since the worker sent `stages`, s; it sends them less often than its sign of life."""
    last_times: dict[str, Nanoseconds] = field(default_factory=dict)
    """Capture times, ns, of the last frames of a limited run, by source, as far as sources know them."""

    def later(self, seconds: float) -> WorkerStatus:
        """The status as it is `seconds` later."""
        age = None if self.age_s is None else self.age_s + seconds
        stages_age = None if self.stages_age_s is None else self.stages_age_s + seconds
        return replace(self, age_s=age, stages_age_s=stages_age)


@dataclass(frozen=True)
class HostStatus:
    """The status of a run on one host.

    workers: of this host; counts: the ledger's columns of all edges of the plan, one edge after the other;
    news: faults and their repairs, a line each, oldest first; out: folder of outputs; change: status of the
    newest hot swap; clock: offset from the reference clock; logged: number of the newest log record; age_s:
    time since the host gave this status, s, None before its first.
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
        """True if every worker is in one of these phases."""
        return all(worker.phase in phases for worker in self.workers)


class HostLost(FollowspotError):
    """The host does not answer."""


class HostRefused(FollowspotError):
    """The host refuses a request; the text names the host and the reason."""


class Host(Protocol):
    """One host in one run, local or remote."""

    name: str
    log: RunLog
    """The log of the workers on the host."""

    def prepare(self, order: RunOrder) -> None:
        """Start the workers, which wait for `start`. Raises FollowspotError."""

    @property
    def ask(self) -> Callable[[RunRequest], Any]:
        """Hands a request to the host and returns its answer: start, stop, change, move, relayed orders.

        Raises FollowspotError if the host refuses, HostLost if it does not answer a request with an answer.
        """

    def attend(self, timeout: float) -> None:
        """Supervise the workers for up to `timeout`, s, or wait for a status. Raises HostLost."""

    def status(self) -> HostStatus:
        """The newest status."""

    def close(self) -> bool:
        """End the run on the host and kill its workers that are still alive; False if the host is silent."""


class Others(Protocol):
    """Hosts that a run can reach and that are not part of it yet."""

    def names(self) -> Collection[str]:
        """Names of all hosts whose agents are alive."""

    def host(self, name: str) -> Host:
        """The host of this name, still to be prepared."""
