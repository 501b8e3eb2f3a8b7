"""Orders and answers of a hot swap: all hosts build the replacements first, then all take over.

If one replacement cannot be built, none takes over.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from followspot.control.dispatch import Role, RunRequest
from followspot.graph.plan import PlannedStage
from followspot.graph.subgraph_use import SubgraphUse
from followspot.ranges import Count, Nanoseconds

Step = Literal["build", "hold", "rest", "take_over", "go_on", "discard"]
ChangePhase = Literal["building", "built", "held", "resting", "done", "failed"]
BEFORE_TAKE_OVER: tuple[ChangePhase, ...] = ("built", "held", "resting")
"""Phases in which a host waits for the operator: its new stages are built."""


class ChangeOrder(RunRequest):
    """One step of a change. id: of the change; stages: the replacements; fresh: whether they start without
    the state of the old stages; subgraphs: of the plan after the change, for the hosts.

    plan: the plan after a change in which stages and edges come or go, else None; workers: of the host, those
    that take part in it.

    Several workers come to rest together: in "hold" their sources stop at once; in "rest" these
    go on to `until`, ns, the stages `leaving` give what they still have, and each worker answers once it has
    nothing more to do; all take over, and all go on. A live run has no "hold". turn: counts the steps.
    """

    id: str
    step: Step
    stages: tuple[PlannedStage, ...]
    fresh: bool = False
    subgraphs: tuple[SubgraphUse, ...] | None = None
    workers: tuple[str, ...] = ()
    turn: Count = 0
    until: Nanoseconds = -1
    leaving: tuple[str, ...] = ()
    plan: dict[str, Any] | None = None
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


@dataclass(frozen=True)
class Rested:
    """The state of workers at rest.

    time: newest capture time that a source has sent, ns; window: the widest in which an input of a stage that
    comes or goes matches messages, ns; activity: firings and receipts so far.
    """

    time: Nanoseconds = -1
    window: Nanoseconds = 0
    activity: Count = 0

    @staticmethod
    def of(parts: Collection[Rested]) -> Rested:
        """The state of several workers or hosts together."""
        return Rested(
            max((one.time for one in parts), default=-1),
            max((one.window for one in parts), default=0),
            sum(one.activity for one in parts),
        )


@dataclass(frozen=True)
class ChangeStatus:
    """The status of the newest change, in a worker or on a host. error: why it failed, else ""; turn: of the
    step.
    """

    id: str = ""
    phase: ChangePhase = "done"
    error: str = ""
    turn: Count = 0
    rested: Rested = Rested()
