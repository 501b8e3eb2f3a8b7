"""The request that moves stages: workers whose edges or stages change leave, then all take their places."""

from __future__ import annotations

from typing import Any, ClassVar

from followspot.control.dispatch import Role, RunRequest


class MoveOrder(RunRequest):
    """One step on a host.

    leaving: workers, on whichever host, that tell the state of their stages and exit; plan: what the run is
    to be afterwards, in JSON types, None while workers only leave; states: what moved stages told, by stage;
    trial: only say whether the host could take the plan.
    """

    leaving: tuple[str, ...] = ()
    plan: dict[str, Any] | None = None
    states: dict[str, Any] = {}  # noqa: RUF012  # pydantic copies it, and nobody can assign to it
    trial: bool = False
    roles: ClassVar[tuple[Role, ...]] = ("host",)
