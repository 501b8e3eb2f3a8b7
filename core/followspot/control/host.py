"""The interface of a host for the operator: the order of a run, and the status of its workers.

Both are plain data. A status is complete, not a difference to the one before, so an operator that missed some
needs only the newest.
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
from followspot.transport import wire
from followspot.valid_values.numbers import Age, Count, Incarnation, Last, Nanoseconds

WorkerPhase = Literal["starting", "ready", "running", "absent", "over"]
"""absent: the worker died and will be restarted, or its host does not answer; over: it has ended for good."""


@dataclass(frozen=True)
class RunOrder:
    """Everything that a host needs to prepare a run."""

    run: str
    """Unique name of the run."""
    plan: dict[str, Any]
    """As `plan_to_data` gives it."""
    frames: Count | None = None
    """Number of frames of each camera, None for all."""
    out: str | None = None
    """Folder for outputs, None if the host chooses one."""
    restart: bool = False
    """Whether hosts restart workers that die."""
    detached: bool = False
    """Whether the run goes on without an operator."""
    incarnations: dict[str, Incarnation] = field(default_factory=dict)
    """Of workers that ran under an earlier agent, by name."""
    fired: dict[str, Count] = field(default_factory=dict)
    """Frames that these workers did under the earlier agent, by name."""
    age_s: Age = 0.0
    """How long the run went on under the earlier agent, s."""
    over: tuple[str, ...] = ()
    """Workers of any host that have ended for good."""
    reference: str = ""
    """The run's reference host, which stays when hosts join or leave; "" if the run began without agents."""
    operator: ProcessIdentity = ProcessIdentity()
    code: dict[str, str] = field(default_factory=dict)
    """Digests of the operator's packages and files with the stages of this host, and versions of libraries,
    by name."""
    wire_version: Count = wire.VERSION
    """Of the messages that the operator's stages send."""

    def here(self, plan: dict[str, Any], out: str) -> RunOrder:
        """The order with the plan and the folder of this host."""
        return replace(self, plan=plan, out=out)


@dataclass(frozen=True)
class WorkerStatus:
    """The status of one worker."""

    name: str
    phase: WorkerPhase
    fired: Count = 0
    """Frames done, also before restarts."""
    time: Nanoseconds = -1
    """Newest capture time that a source sent, ns; -1 before the first."""
    expected: Count | None = None
    """Frames to be done, None if unknown."""
    restarts: Incarnation = 0
    """How often the worker was restarted."""
    report: WorkerReport | None = None
    """None until the worker has ended."""
    stages: tuple[StageStatus, ...] = ()
    paths: tuple[PathStatus, ...] = ()
    age_s: Age | None = None
    """Time since the worker's last message, s; None if there was none."""
    host: str = ""
    """The worker's host, "" for the operator's own."""
    stages_age_s: Age | None = None
    """Time since the worker sent `stages`, s; it sends them less often than heartbeats."""
    last_times: dict[str, Nanoseconds] = field(default_factory=dict)
    """Capture times, ns, of the last frames of a limited run, by source, as far as sources know them."""

    def later(self, seconds: float) -> WorkerStatus:
        """The status as it is `seconds` later."""
        age = None if self.age_s is None else self.age_s + seconds
        stages_age = None if self.stages_age_s is None else self.stages_age_s + seconds
        return replace(self, age_s=age, stages_age_s=stages_age)


@dataclass(frozen=True)
class HostStatus:
    """The status of a run on one host."""

    workers: tuple[WorkerStatus, ...]
    """The workers of this host."""
    counts: tuple[Count, ...]
    """The ledger's columns of all edges of the plan, one edge after the other."""
    news: tuple[str, ...] = ()
    """Faults and their repairs, a line each, oldest first."""
    out: str = ""
    """Folder of outputs."""
    change: ChangeStatus = ChangeStatus()
    """The status of the newest hot swap."""
    clock: ClockStatus = ClockStatus()
    """The offset from the reference clock."""
    logged: Last = -1
    """Number of the newest log record."""
    age_s: Age | None = None
    """Time since the host gave this status, s; None before its first."""

    def all(self, *phases: WorkerPhase) -> bool:
        """True if every worker is in one of these phases."""
        return all(worker.phase in phases for worker in self.workers)


class HostLost(FollowspotError):
    """The host does not answer."""


class HostRefused(FollowspotError):
    """The host refuses a request; the text names the host and the reason."""


class HostRefusedTime(HostRefused):
    """The host refuses a request because it says another time than the host's clock."""


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
