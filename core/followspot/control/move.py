"""The steps of a move, as orders: workers whose edges or stages change leave, then all take their places."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pydantic


@dataclass(frozen=True)
class MoveOrder:
    """One step on a host.

    leaving: workers, here or elsewhere, that tell the state of their stages and go; plan: what all are to be
    afterwards, in JSON types, None while they only leave; states: what moved stages told, by stage;
    trial: only say whether the plan could be taken.
    """

    leaving: tuple[str, ...] = ()
    plan: dict[str, Any] | None = None
    states: dict[str, Any] = field(default_factory=dict)
    trial: bool = False

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return {
            "leaving": list(self.leaving),
            "plan": self.plan,
            "states": self.states,
            "trial": self.trial,
        }


_ORDER: pydantic.TypeAdapter[MoveOrder] = pydantic.TypeAdapter(MoveOrder)


def move_from_data(data: Any) -> MoveOrder:
    """An order that came from elsewhere. Raises ValueError."""
    return _ORDER.validate_python(data)
