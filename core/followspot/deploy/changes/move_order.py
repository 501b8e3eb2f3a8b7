"""The steps of a move, as orders: workers whose edges or stages change leave, then all take their places."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pydantic


@dataclass(frozen=True)
class MoveOrder:
    """One step on a host.

    leaving: workers that tell the state of their stages and go; plan: what all are to be afterwards, in JSON
    types, None while they only leave; states: what moved stages told, by stage.
    """

    leaving: tuple[str, ...] = ()
    plan: dict[str, Any] | None = None
    states: dict[str, Any] = field(default_factory=dict)

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return {"leaving": list(self.leaving), "plan": self.plan, "states": self.states}


_ORDER: pydantic.TypeAdapter[MoveOrder] = pydantic.TypeAdapter(MoveOrder)


def move_from_data(data: Any) -> MoveOrder:
    """An order that came from elsewhere. Raises ValueError."""
    return _ORDER.validate_python(data)
