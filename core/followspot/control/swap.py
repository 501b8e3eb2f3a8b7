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
from followspot.valid_values.numbers import Count, Nanoseconds

Step = Literal["build", "hold", "rest", "take_over", "go_on", "discard"]
ChangePhase = Literal["building", "built", "held", "resting", "done", "failed"]
BEFORE_TAKE_OVER: tuple[ChangePhase, ...] = ("built", "held", "resting")
"""Phases in which a host waits for the operator: its new stages are built."""


class ChangeOrder(RunRequest):
    """One step of a change.

    A swap of stages has the steps "build" and "take_over". A change of stages and edges in several workers
    also brings them to rest: in "hold" their sources stop at once (not in a live run); in "rest" the sources
    go on to `until`, the stages `leaving` send their remaining messages, and each worker answers once it has
    nothing more to do. After "take_over" all workers "go_on". "discard" undoes a change that failed.
    """

    id: str
    """Of the change."""
    step: Step
    stages: tuple[PlannedStage, ...]
    """The replacements."""
    fresh: bool = False
    """Whether replacements start without the state of the old stages."""
    subgraphs: tuple[SubgraphUse, ...] | None = None
    """The sub-graphs of the plan after the change, for the hosts."""
    workers: tuple[str, ...] = ()
    """The workers of the host that take part in a change of stages and edges."""
    turn: Count = 0
    """Number of the step."""
    until: Nanoseconds = -1
    """Capture time up to which the sources send in "rest", ns."""
    leaving: tuple[str, ...] = ()
    """Stages that send their remaining messages in "rest"."""
    plan: dict[str, Any] | None = None
    """The plan after a change of stages and edges; None if only stages are swapped."""
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


@dataclass(frozen=True)
class Rested:
    """The state of workers at rest."""

    time: Nanoseconds = -1
    """Newest capture time that a source has sent, ns."""
    window: Nanoseconds = 0
    """Widest window in which an input of a stage that comes or goes matches messages, ns."""
    activity: Count = 0
    """Firings and received messages so far."""

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
    """The status of the newest change, in a worker or on a host."""

    id: str = ""
    phase: ChangePhase = "done"
    error: str = ""
    """Why the change failed; "" if it did not."""
    turn: Count = 0
    """Number of the step."""
    rested: Rested = Rested()
