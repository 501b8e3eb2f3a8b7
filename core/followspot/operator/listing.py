"""The parts of runs that an agent has, as it lists them for operators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import pydantic

from followspot.control.origin import Origin
from followspot.control.zenoh_rpc import RpcClient
from followspot.errors import FollowspotError
from followspot.ranges import Age

_Name = Annotated[str, pydantic.Field(max_length=1000)]


@dataclass(frozen=True)
class ListedPart:
    """One of them. detached: whether it goes on alone; silent_s: since when no operator asked for it, s."""

    run: _Name
    graph: _Name
    over: bool
    detached: bool = False
    silent_s: Age = 0.0
    origin: Origin = Origin()


_LISTING: pydantic.TypeAdapter[list[ListedPart]] = pydantic.TypeAdapter(list[ListedPart])


def parts_of(client: RpcClient, agent: str) -> Sequence[ListedPart]:
    """What an agent has. Raises HostLost, and FollowspotError where its answer is none."""
    try:
        return _LISTING.validate_python(client.ask(agent, "runs"))
    except pydantic.ValidationError as error:
        raise FollowspotError(f"host {agent}: its runs are none: {error.errors()[0]['msg']}") from None
