"""The request that moves stages: workers whose edges or stages change leave, then start at new places."""

from __future__ import annotations

from typing import Any, ClassVar

from followspot.control.dispatch import Role, RunRequest
from followspot.ranges import Count

MOVE_TIMEOUT = 60.0
"""Seconds after which workers that left for a move are started again if no operator ends the move."""


class MoveOrder(RunRequest):
    """One step of a move on a host.

    leaving: workers of any host that send checkpoints of their stages and exit; plan: the new plan in JSON
    types, None while workers only leave; states: checkpoints of the moved stages, by stage; fired: frames
    that the sinks of a worker did before, by worker; trial: only check whether the host would accept the
    plan; back: a step of the way back after a move that failed: a host that does not answer now does it as
    soon as it answers.
    """

    leaving: tuple[str, ...] = ()
    plan: dict[str, Any] | None = None
    states: dict[str, Any] = {}  # noqa: RUF012  # pydantic copies it, and requests are frozen
    fired: dict[str, Count] = {}  # noqa: RUF012
    trial: bool = False
    back: bool = False
    roles: ClassVar[tuple[Role, ...]] = ("host",)
