"""The requests that tap ports: their messages also go to further sinks, until the taps are removed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from followspot.control.relay import Relayed
from followspot.errors import FollowspotError
from followspot.graph.parameters import path_parameters
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.stage_params import PathIn, PathOut


@dataclass(frozen=True)
class Tapping:
    """A tap at a port. port: STAGE.PORT; uses, params: the sink that gets its messages."""

    port: str
    uses: str
    params: Mapping[str, Any]


class _TapOrder(Relayed):
    """Base of orders about taps."""

    taps: tuple[Tapping, ...]

    def part_for(self, stages: Collection[str]) -> Self:
        """The taps at these stages."""
        mine = (tapping for tapping in self.taps if tapping.port.rpartition(".")[0] in stages)
        return self.model_copy(update={"taps": tuple(mine)})


class PlaceTaps(_TapOrder):
    """Place taps at ports."""

    def check(self, plan: Plan, *, remote: bool) -> None:
        """Raise FollowspotError if a sink is not a tap, or uses files though another host sent the order."""
        for tapping in self.taps:
            kind = _tap_class(tapping)
            files = (*path_parameters(kind.Params, PathIn), *path_parameters(kind.Params, PathOut))
            if remote and any(tapping.params.get(name) is not None for name in files):
                raise FollowspotError(f"a tap here has no files: {tapping.uses} at {tapping.port}")

    def without(self, taps: Collection[Tapping]) -> Self:
        """The order without these taps."""
        return self.model_copy(update={"taps": tuple(tap for tap in self.taps if tap not in taps)})


class RemoveTaps(_TapOrder):
    """Remove taps that `PlaceTaps` has placed, from workers that start later as well."""

    def check(self, plan: Plan, *, remote: bool) -> None:
        """Accept all: a tap that does not exist counts as removed."""

    def standing(self, before: Sequence[Relayed]) -> list[Relayed]:
        """The earlier orders without these taps."""
        left = [order.without(self.taps) if isinstance(order, PlaceTaps) else order for order in before]
        return [order for order in left if not isinstance(order, PlaceTaps) or order.taps]


def _tap_class(tapping: Tapping) -> type[Stage]:
    kind = load_stage(tapping.uses)
    if not kind.tap or ports(kind).outputs:
        raise FollowspotError(
            f"{tapping.uses} cannot be placed at {tapping.port} while the graph runs: it is no tap; "
            "a sink that other programs need belongs in the graph"
        )
    return kind
