"""Sub-graphs that may be left out: `optional: true` of a stage that is a graph file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from followspot.errors import Mistake, Place
from followspot.graph.compose.feeds import items, option, sender
from followspot.graph.compose.senders import senders
from followspot.graph.compose.unit import Unit
from followspot.graph.names import below


@dataclass(frozen=True)
class OptionalUse:
    """A sub-graph that is left out if all that feeds it is. senders: stages that feed it without a delay."""

    name: str
    place: Place
    senders: frozenset[str]


def optional_uses(unit: Unit) -> Iterator[OptionalUse]:
    """The optional sub-graphs below a unit, outer ones first, as far as something feeds them."""
    for inner in (inner for found in unit.units.values() for inner in found):
        feeding = frozenset(_senders(inner)) if inner.optional is not None else frozenset()
        if inner.optional is not None and feeding:
            yield OptionalUse(inner.name, inner.optional, feeding)
        yield from optional_uses(inner)


def left_out_below(unit: Unit) -> dict[str, Mistake]:
    """The sub-graphs that the room has nothing for, by their full names, with the reasons."""
    found = {below(unit.name, name): reason for name, reason in unit.left_out.items()}
    for inner in (inner for units in unit.units.values() for inner in units):
        found |= left_out_below(inner)
    return found


def _senders(unit: Unit) -> Iterator[str]:
    """Full names of the stages that feed the inputs of a sub-graph without a delay."""
    for wired in unit.inputs.values():
        for item in items(wired.feeds):
            for feed in senders(wired.unit, item, []):
                named = sender(feed)
                if named is not None and option(feed, "delay") is None:
                    yield named[0]
