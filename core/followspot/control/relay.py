"""Orders that the operator relays through all hosts to all workers, also to workers that start later."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import ClassVar, Self

from followspot.control.dispatch import Role, RunRequest
from followspot.graph.plan import Plan


class Relayed(RunRequest):
    """Base of the relayed orders."""

    roles: ClassVar[tuple[Role, ...]] = ("operator", "host", "worker")

    def check(self, plan: Plan, *, remote: bool) -> None:
        """Raise FollowspotError if the order does not fit the plan. remote: whether another host sent it."""

    def check_after(self, before: Relayed) -> None:
        """Raise FollowspotError if the order does not fit the last order of its type."""

    def part_for(self, stages: Collection[str]) -> Self:
        """The order, reduced to the parts that these stages need."""
        return self

    def standing(self, before: Sequence[Relayed]) -> list[Relayed]:
        """The orders for workers that start later. before: the standing orders before this one."""
        return [*(order for order in before if order != self), self]
