"""A request for a look at a port."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from followspot.control.dispatch import Role, RunRequest
from followspot.errors import FollowspotError
from followspot.plugins.registry import load_stage
from followspot.ports import ports


@dataclass(frozen=True)
class Tapping:
    """port: STAGE.PORT that is looked at; uses, params: the sink that gets its messages."""

    port: str
    uses: str
    params: Mapping[str, Any]


class PlaceTaps(RunRequest):
    """Put sinks at ports."""

    taps: tuple[Tapping, ...]
    roles: ClassVar[tuple[Role, ...]] = ("operator", "host", "worker")


def check_taps(tappings: Iterable[Tapping]) -> None:
    """Raises FollowspotError where a stage does not say of itself that it may be put at a port so."""
    for tapping in tappings:
        kind = load_stage(tapping.uses)
        if not kind.tap or ports(kind).outputs:
            raise FollowspotError(
                f"{tapping.uses} cannot look at {tapping.port} while the graph runs: it is no tap; "
                "a sink that other programs need stands in the graph"
            )
