"""Orders and answers of a hot swap: all hosts build the replacements first, then all take over.

If one replacement cannot be built, none takes over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from followspot.control.dispatch import Role, RunRequest
from followspot.graph.plan import PlannedStage
from followspot.graph.subgraph_use import SubgraphUse

Step = Literal["build", "take_over", "discard"]
ChangePhase = Literal["building", "built", "done", "failed"]


class ChangeOrder(RunRequest):
    """One step of a change. id: of the change; stages: the replacements; fresh: whether they start without
    the state of the old stages; subgraphs: of the plan after the change, for the hosts.

    plan: the plan after a change in which stages and edges come or go, all of them in `worker`; else None.
    """

    id: str
    step: Step
    stages: tuple[PlannedStage, ...]
    fresh: bool = False
    subgraphs: tuple[SubgraphUse, ...] | None = None
    worker: str = ""
    plan: dict[str, Any] | None = None
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


@dataclass(frozen=True)
class ChangeStatus:
    """The status of the newest change, in a worker or on a host. error: why it failed, else ""."""

    id: str = ""
    phase: ChangePhase = "done"
    error: str = ""
