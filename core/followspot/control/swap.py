"""The steps of a change to a running graph, as orders and answers: build everywhere, then take over.

Where one successor cannot be built, none takes over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from followspot.control.dispatch import Role, RunRequest
from followspot.graph.plan import PlannedStage

Step = Literal["build", "take_over", "discard"]
ChangePhase = Literal["building", "built", "done", "failed"]


class ChangeOrder(RunRequest):
    """One step. id: of the change; stages: as they are to be; fresh: without the state of the old ones."""

    id: str
    step: Step
    stages: tuple[PlannedStage, ...]
    fresh: bool = False
    roles: ClassVar[tuple[Role, ...]] = ("host", "worker")


@dataclass(frozen=True)
class ChangeStatus:
    """How far the newest change is, in a worker or on a host. error: why it failed."""

    id: str = ""
    phase: ChangePhase = "done"
    error: str = ""
