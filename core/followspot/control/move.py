"""The request that moves stages: workers whose edges or stages change leave, then start at new places."""

from __future__ import annotations

from typing import Any, ClassVar

from followspot.control.dispatch import Role, RunRequest
from followspot.valid_values.numbers import Count

MOVE_TIMEOUT = 60.0
"""Seconds after which workers that left for a move are started again if no operator ends the move."""


class MoveOrder(RunRequest):
    """One step of a move on a host."""

    leaving: tuple[str, ...] = ()
    """Workers of any host that send checkpoints of their stages and exit."""
    plan: dict[str, Any] | None = None
    """The new plan in JSON types, None while workers only leave."""
    states: dict[str, Any] = {}  # noqa: RUF012  # pydantic copies it, and requests are frozen
    """Checkpoints of the moved stages, by stage."""
    fired: dict[str, Count] = {}  # noqa: RUF012
    """Frames that the sinks of a worker did before, by worker."""
    trial: bool = False
    """Only check whether the host would accept the plan."""
    back: bool = False
    """Whether a failed move is undone: a silent host then does the step as soon as it answers."""
    roles: ClassVar[tuple[Role, ...]] = ("host",)
