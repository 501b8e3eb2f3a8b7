"""Which file and line each stage of a composed graph and each of its values comes from."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace

from followspot.errors import Place, shown
from followspot.graph.compose.compose import ComposedGraph
from followspot.yaml.node import Node, plain

_BY_KEY = ("in", "with")


def origin_text(composed: ComposedGraph) -> str:
    """A line for each stage, and below it one for each value."""
    rows = [("graph " + composed.name, composed.place)]
    rows += [(f"room {plain(composed.room)}", composed.room.place)] if composed.room is not None else []
    for name, node in composed.stages.items():
        rows.append((name, node.key))
        rows += [(f"  {key}: {value}", replace(place, outer=None)) for key, value, place in _values(node)]
    width = max(len(text) for text, _ in rows)
    return "".join(f"{shown(text):<{width}}  {_where(place)}\n" for text, place in rows)


def _values(node: Node) -> Iterator[tuple[str, str, Place]]:
    """The keys of a stage with their values and places; inputs and parameters one by one."""
    entries = node.value if isinstance(node.value, Mapping) else {}
    for key, entry in entries.items():
        if key in _BY_KEY and isinstance(entry.value, Mapping):
            for name, inner in entry.value.items():
                yield f"{key}.{name}", _shown(inner), _place(inner)
        else:
            yield key, _shown(entry), entry.place


def _place(node: Node) -> Place:
    """The place of a value; for a feed, the place of its sender."""
    first = node.value[0] if isinstance(node.value, tuple) and node.value else node
    sender = first.value.get("from") if isinstance(first.value, Mapping) else None
    return (sender or first).place


def _shown(node: Node) -> str:
    value = plain(node)
    return value if isinstance(value, str) else json.dumps(value)


def _where(place: Place) -> str:
    """The place, and the places that brought it into the graph."""
    lines = [f"{found.file}:{found.line}" for found in (place, *place.outer_places)]
    return " < ".join(dict.fromkeys(lines))
