"""The ports behind the outputs of sub-graphs: `hall.tracks` is hall/track.tracks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from followspot.graph.compose.feeds import option, sender
from followspot.graph.instances import CheckedStage
from followspot.graph.selector import read_selector
from followspot.ports.signature import ports
from followspot.room import Room
from followspot.yaml.node import Node


def subgraph_ports(
    outputs: Mapping[str, Sequence[Node]], stages: Sequence[CheckedStage], room: Room
) -> dict[str, tuple[str, ...]]:
    """The ports, STAGE.PORT each, behind each output, SUBGRAPH.NAME; none behind one that is left out.

    outputs: with what feeds a reader of each. Of a stage without a named port all ports count.
    """
    groups: dict[str, list[CheckedStage]] = {}
    for stage in stages:
        groups.setdefault(stage.instance.declared.name, []).append(stage)
    found = {
        name: tuple(dict.fromkeys(port for feed in feeds for port in _ports(feed, groups, room)))
        for name, feeds in outputs.items()
    }
    return {name: named for name, named in found.items() if named}


def _ports(feed: Node, groups: Mapping[str, Sequence[CheckedStage]], room: Room) -> Iterator[str]:
    """The ports that a feed of an input comes from."""
    stage, port = sender(feed) or ("", None)
    only = option(feed, "only")
    chosen = None if only is None else read_selector(only, []).select(room)
    for one in groups.get(stage, ()):
        if chosen is None or one.instance.member in chosen:
            names = [port] if port is not None else [output.name for output in ports(one.stage).outputs]
            yield from (f"{one.instance.name}.{name}" for name in names)
