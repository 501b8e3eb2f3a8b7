"""Edges from and to stages that are left out of a room: their types do not depend on what the room has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from followspot.graph.compose.feeds import sender
from followspot.graph.declaration import ROOM_SOURCE, Feed
from followspot.graph.expand import ExpandedGraph
from followspot.graph.instances import Instance, Wire


def unserved_wires(expanded: ExpandedGraph) -> Iterator[Wire]:
    """A wire for each feed from or to a stage that is left out, as if it were there.

    Sources that the room declares are left aside: those of another room may be others.
    """
    absent = {instance.declared.name: instance for instance in expanded.unserved}
    if not absent:
        return
    known: dict[str, Instance] = {}
    for instance in expanded.instances.values():
        known.setdefault(instance.declared.name, instance)
    known |= absent
    for target in known.values():
        for entry in target.declared.inputs:
            for feed in (inner for written in entry.feeds for inner in _through(written, known, expanded)):
                source = known[feed.stage]
                there = target.declared.name in absent or feed.stage in absent
                if there and source.declared.uses != ROOM_SOURCE:
                    yield Wire(source, feed, target, entry.port, entry.place)


def _through(feed: Feed, known: Mapping[str, Instance], expanded: ExpandedGraph) -> Iterator[Feed]:
    """The feed, or those behind the output of a sub-graph that it names; none of an unknown stage."""
    if feed.stage in known:
        yield feed
        return
    outputs = [name for name in expanded.outputs if name.partition(".")[0] == feed.stage]
    named = f"{feed.stage}.{feed.port}" if feed.port is not None else outputs[0] if len(outputs) == 1 else ""
    for node in expanded.outputs.get(named, ()):
        found = sender(node)
        if found is not None and found[0] in known:
            yield replace(feed, stage=found[0], port=found[1])
