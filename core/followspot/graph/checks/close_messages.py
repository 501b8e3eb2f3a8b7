"""Joins in a loop whose messages follow each other within the time for which a join closes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from followspot.errors import Mistake
from followspot.graph.checks.flow import Flow
from followspot.graph.checks.rates import rates
from followspot.graph.connections import CheckedEdge
from followspot.graph.cycles import cyclic
from followspot.graph.instances import CheckedStage
from followspot.ports import ports
from followspot.room import Room

_SPARE = 0.9
"""Share of the time between messages that the remedy lets joins close for: times are never quite even."""
_TIMED = ("several", "lagged")
"""What stages give that close nothing for their readers: each message has a time of its own."""


@dataclass(frozen=True)
class Closing:
    """For how long a stage fires no more after a firing, s, and the joins on its path that add up to it."""

    seconds: float = 0.0
    joins: tuple[str, ...] = ()


def joins_of_close_messages(flow: Flow, room: Room) -> Iterator[Mistake]:
    """Joins in a loop that would discard every other message or more; some loops wait for those forever."""
    loops = {target for _, target in cyclic([(e.wire.source.name, e.wire.target.name) for e in flow.edges])}
    found, closings = rates(flow, room), _closings(flow)
    named: set[str] = set()
    for name in reversed(flow.order):
        rate, closing, reader = found[name], closings[name], flow.stages[name]
        own = reader.instance.declared.name
        if rate is None or rate * closing.seconds < 1 or own not in closing.joins or name not in loops:
            continue
        if own not in named:  # one that closes for longer has it among its joins
            named.update(closing.joins)
            yield _mistake(reader, rate, closing)


def _mistake(reader: CheckedStage, rate: float, closing: Closing) -> Mistake:
    name = reader.instance.declared.name
    text = (
        f'{rate:g} messages/s reach stage "{name}", which is in a loop, but by the tolerances of the joins '
        f"{', '.join(closing.joins)} it fires once in {1000 * closing.seconds:g} ms at most"
    )
    tolerance = f"{_SPARE / rate / len(closing.joins):.2g}"
    settings = " ".join(f"--set {join}.tolerance={tolerance}" for join in closing.joins)
    return Mistake(
        reader.instance.declared.place, text, f"give these a smaller one ({settings}), or lower the rate"
    )


def _closings(flow: Flow) -> Mapping[str, Closing]:
    """The closing of each instance: the longest of its senders, and on top that of its own join."""
    closings: dict[str, Closing] = {}
    for name in flow.order:
        reader, edges = flow.stages[name], flow.firing_edges[name]
        passed = [
            closings[e.wire.source.name]
            for e in edges
            if ports(flow.stages[e.wire.source.name].stage).gives not in _TIMED
        ]
        longest = max(passed, key=lambda closing: closing.seconds, default=Closing())
        window = _window(reader, edges)
        own = (reader.instance.declared.name,) if window else ()
        closings[name] = Closing(longest.seconds + window, longest.joins + own)
    return closings


def _window(reader: CheckedStage, edges: Sequence[CheckedEdge]) -> float:
    """Largest difference in capture time within a join, s; 0 for a stage that joins nothing."""
    written = [edge.wire.feed.tolerance for edge in edges]
    found = [reader.tolerance if tolerance is None else tolerance for tolerance in written]
    return max(found) if len(found) > 1 else 0.0
