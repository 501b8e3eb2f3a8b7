"""Orders that the operator relays through all hosts to all workers, and to workers that begin later."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, ClassVar, Self

from followspot.control.dispatch import Role, RunRequest
from followspot.graph.plan import Plan


class Relayed(RunRequest):
    """Base of these orders."""

    roles: ClassVar[tuple[Role, ...]] = ("operator", "host", "worker")

    def check(self, plan: Plan, *, remote: bool) -> None:
        """Raises FollowspotError if a run of this plan refuses it. remote: whether another host sent it."""

    def part_for(self, stages: Collection[str]) -> Self:
        """What concerns these stages."""
        return self

    def replaces(self, other: Relayed) -> bool:
        """Whether workers that begin later need not be told of the other one."""
        return self == other


def with_order(standing: Sequence[Any], order: Relayed) -> list[Any]:
    """What workers that begin later are told, after one more order."""
    return [*(other for other in standing if not order.replaces(other)), order]
