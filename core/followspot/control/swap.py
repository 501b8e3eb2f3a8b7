"""The steps of a change to a running graph, as orders and answers: build everywhere, then take over.

Where one successor cannot be built, none takes over.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import pydantic

from followspot.graph.plan import PlannedStage

Step = Literal["build", "take_over", "give_up"]
ChangePhase = Literal["building", "built", "done", "failed"]


@dataclass(frozen=True)
class ChangeOrder:
    """One step. id: of the change; stages: as they are to be; fresh: without the state of the old ones."""

    id: str
    step: Step
    stages: tuple[PlannedStage, ...]
    fresh: bool = False

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return {**asdict(self), "stages": [{**asdict(s), "params": dict(s.params)} for s in self.stages]}


@dataclass(frozen=True)
class ChangeStatus:
    """How far the newest change is, in a worker or on a host. error: why it failed."""

    id: str = ""
    phase: ChangePhase = "done"
    error: str = ""


_ORDER: pydantic.TypeAdapter[ChangeOrder] = pydantic.TypeAdapter(ChangeOrder)


def change_from_data(data: Any) -> ChangeOrder:
    """An order that came from elsewhere. Raises ValueError."""
    return _ORDER.validate_python(data)
