"""Orders that the operator relays through all hosts to all workers, also to workers that start later."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, ClassVar, Self

from followspot.control.dispatch import Role, RunRequest
from followspot.graph.plan import Plan


class Relayed(RunRequest):
    """Base of the relayed orders."""

    roles: ClassVar[tuple[Role, ...]] = ("operator", "host", "worker")

    def check(self, plan: Plan, *, remote: bool) -> None:
        """Raise FollowspotError if the order does not fit the plan. remote: whether another host sent it."""

    def part_for(self, stages: Collection[str]) -> Self:
        """The order reduced to what these stages need."""
        return self

    def replaces(self, other: Relayed) -> bool:
        """True if workers that start later need only this order, not the other."""
        return self == other


def with_order(standing: Sequence[Any], order: Relayed) -> list[Any]:
    """The orders for workers that start later, with one more order added."""
    return [*(other for other in standing if not order.replaces(other)), order]
