"""Joins in a loop that gets messages faster than the joins can fire."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from followspot.errors import Mistake
from followspot.graph.checks.flow import Flow
from followspot.graph.checks.rates import rates
from followspot.graph.connections import CheckedEdge
from followspot.graph.cycles import cyclic
from followspot.graph.instances import CheckedStage
from followspot.ports.signature import ports
from followspot.room import Room

_SPARE = 0.9
"""Share of the time between messages that the remedy lets joins close for: times are never quite even."""
_TIMED = ("several", "lagged")
"""Kinds of stages whose outputs do not close joins downstream: each message has a time of its own."""


@dataclass(frozen=True)
class ClosedTime:
    """How long a stage does not fire after a firing, s, and the joins whose tolerances add up to that."""

    seconds: float = 0.0
    joins: tuple[str, ...] = ()


def joins_in_fast_loops(flow: Flow, room: Room) -> Iterator[Mistake]:
    """Joins in a loop that would discard every other message or more; some loops wait for those forever."""
    loops = {target for _, target in cyclic([(e.wire.source.name, e.wire.target.name) for e in flow.edges])}
    found, closed_times = rates(flow, room), _closed_times(flow)
    named: set[str] = set()
    for name in reversed(flow.order):
        rate, closed, reader = found[name], closed_times[name], flow.stages[name]
        own = reader.instance.declared.name
        if rate is None or rate * closed.seconds < 1 or own not in closed.joins or name not in loops:
            continue
        if own not in named:  # else the mistake of a stage downstream names it
            named.update(closed.joins)
            yield _mistake(reader, rate, closed)


def _mistake(reader: CheckedStage, rate: float, closed: ClosedTime) -> Mistake:
    name = reader.instance.declared.name
    text = (
        f'{rate:g} messages/s reach stage "{name}", which is in a loop, but by the tolerances of the joins '
        f"{', '.join(closed.joins)} it fires once in {1000 * closed.seconds:g} ms at most"
    )
    tolerance = f"{_SPARE / rate / len(closed.joins):.2g}"
    settings = " ".join(f"--set {join}.tolerance={tolerance}" for join in closed.joins)
    return Mistake(
        reader.instance.declared.place, text, f"give these a smaller one ({settings}), or lower the rate"
    )


def _closed_times(flow: Flow) -> Mapping[str, ClosedTime]:
    """The closed time of each instance: the longest of its senders' plus the window of its own join."""
    closed_times: dict[str, ClosedTime] = {}
    for name in flow.order:
        reader, edges = flow.stages[name], flow.firing_edges[name]
        passed = [
            closed_times[e.wire.source.name]
            for e in edges
            if ports(flow.stages[e.wire.source.name].stage).gives not in _TIMED
        ]
        longest = max(passed, key=lambda closed: closed.seconds, default=ClosedTime())
        window = _window(reader, edges)
        own = (reader.instance.declared.name,) if window else ()
        closed_times[name] = ClosedTime(longest.seconds + window, longest.joins + own)
    return closed_times


def _window(reader: CheckedStage, edges: Sequence[CheckedEdge]) -> float:
    """Largest difference in capture time within a join, s; 0 for a stage that joins nothing."""
    written = [edge.wire.feed.tolerance for edge in edges]
    found = [reader.tolerance if tolerance is None else tolerance for tolerance in written]
    return max(found) if len(found) > 1 else 0.0
