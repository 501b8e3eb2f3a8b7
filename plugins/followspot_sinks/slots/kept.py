"""Sinks whose slots are part of their state."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

from followspot_sinks.slots.persons import PersonSlots
from followspot_sinks.slots.targets import TargetSlots

Keeper = TypeVar("Keeper", TargetSlots, PersonSlots)


class KeepsSlots(Generic[Keeper]):
    """Base of sinks that keep their slots when their worker is started again; `keeper` has them."""

    keeper: Keeper

    def state(self) -> Any:
        """The slots."""
        return self.keeper.state()

    def restore(self, state: Any) -> None:
        """Carry on from this state."""
        self.keeper.restore(state)
