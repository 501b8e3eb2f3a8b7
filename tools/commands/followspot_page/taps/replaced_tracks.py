"""Tracks that another stage makes tracks of: a target is drawn where the last of them have it now."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.tracking import Tracks


def followed(plan: Plan) -> frozenset[str]:
    """The ports, STAGE.PORT, whose tracks are not drawn, because those of another stage are.

    They reach a stage that sends tracks, or they come late (`Lagged`) from tracks that are drawn at once.
    Feedback counts for nothing.
    """
    its = {stage.name: ports(load_stage(stage.uses)) for stage in plan.stages}
    readers = _readers(plan)
    late = {name for name, of in its.items() if of.gives == "lagged"}
    late |= _reached(late, readers)
    tracks = {
        f"{name}.{port.name}": name
        for name, of in its.items()
        for port in of.outputs
        if issubclass(port.type, Tracks)
    }
    trackers = set(tracks.values())
    at_once = _reached((port for port, stage in tracks.items() if stage not in late), readers)
    return frozenset(
        port
        for port, stage in tracks.items()
        if (stage in late and stage in at_once)
        or _reached([port], readers) & (trackers if stage in late else trackers - late)
    )


def _readers(plan: Plan) -> Mapping[str, Iterable[str]]:
    """The stages that take from each stage, and from each port, in the same firing."""
    found: dict[str, set[str]] = {}
    for edge in plan.edges:
        if edge.delay == 0:
            for start in (edge.from_stage, f"{edge.from_stage}.{edge.from_port}"):
                found.setdefault(start, set()).add(edge.to_stage)
    return found


def _reached(starts: Iterable[str], readers: Mapping[str, Iterable[str]]) -> set[str]:
    """All stages behind ports or stages."""
    found: set[str] = set()
    waiting = [stage for start in starts for stage in readers.get(start, ())]
    while waiting:
        stage = waiting.pop()
        if stage not in found:
            found.add(stage)
            waiting += readers.get(stage, ())
    return found
