"""Joins of streams with different rates: most messages of the faster stream find no partner."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from followspot.errors import Mistake
from followspot.graph.checks.flow import Flow
from followspot.graph.connections import CheckedEdge
from followspot.graph.instances import CheckedStage
from followspot.room import Room

_ALIKE = 1.5
"""Rates that differ by less may be those of one device, told roughly."""


def nominal_rate(checked: CheckedStage, room: Room) -> float | None:
    """Messages per second of a source, Hz, if the room or the source itself says."""
    member = checked.instance.member
    written = room.sensors[member.name].rate if member is not None and member.set == "sensors" else None
    return written or checked.stage.nominal_rate(checked.stage.Params(**checked.params))


def joins_of_unequal_rates(flow: Flow, room: Room) -> Iterator[Mistake]:
    """Stages that join streams of known, different rates: a join gives as many sets as the slowest has."""
    known_rates = rates(flow, room)
    for name, edges in flow.firing_edges.items():
        reader = flow.stages[name]
        if not reader.tolerance:  # it takes each message by itself
            continue
        known = [(rate, edge) for edge in edges if (rate := known_rates[edge.wire.source.name]) is not None]
        if not known:
            continue
        slowest, fastest = (pick(known, key=lambda found: found[0]) for pick in (min, max))
        if fastest[0] > _ALIKE * slowest[0]:
            yield _mistake(reader, fastest, slowest)


def _mistake(
    reader: CheckedStage, fastest: tuple[float, CheckedEdge], slowest: tuple[float, CheckedEdge]
) -> Mistake:
    (most, fast), (least, slow) = fastest, slowest
    name, one, other = reader.instance.declared.name, fast.wire.feed.stage, slow.wire.feed.stage
    text = (
        f'stage "{name}" joins {most:g} messages/s of stage "{one}" with {least:g} of stage "{other}"; '
        f"of the first, {1 - least / most:.0%} find no partner"
    )
    remedy = "give each a stage of its own, or take the faster as Window[...], Nearest[...] or Latest[...]"
    return Mistake(fast.wire.feed.place, text, remedy)


def rates(flow: Flow, room: Room) -> Mapping[str, float | None]:
    """Firings per second of each instance, Hz: that of a source, or of the slowest stream that is joined."""
    found: dict[str, float | None] = {}
    for name in flow.order:
        senders = [found[edge.wire.source.name] for edge in flow.firing_edges[name]]
        known = [rate for rate in senders if rate is not None]
        found[name] = min(known) if known else None if senders else nominal_rate(flow.stages[name], room)
    return found
