"""Stages that an overlay removes although others still need them."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.errors import Mistake, Place
from followspot.graph.compose.feeds import items, sender
from followspot.graph.compose.graph_file import GraphFile


def check_removed(file: GraphFile, mistakes: list[Mistake]) -> None:
    """Note removed stages that others still read, or the interface names."""
    for name, place in file.removed.items():
        readers = [*_readers(name, file)]
        if not readers:
            continue
        listed = ", ".join(dict.fromkeys(reader for reader, _ in readers))
        text = f'stage "{name}" is removed, but read by: {listed}'
        remedy = "feed them from another stage, or remove them too"
        mistakes.append(Mistake(place.beside(readers[0][1]), text, remedy))


def _readers(name: str, file: GraphFile) -> list[tuple[str, Place]]:
    """Stages with inputs from this one, and entries of the interface that name it."""
    found = []
    for stage, node in file.stages.items():
        inputs = node.value.get("in") if isinstance(node.value, Mapping) else None
        if inputs is not None and isinstance(inputs.value, Mapping):
            feeds = [feed for entry in inputs.value.values() for feed in items(entry)]
            found += [(stage, feed.place) for feed in feeds if (sender(feed) or ("",))[0] == name]
    for key, entries in (("params", file.params), ("inputs", file.inputs), ("outputs", file.outputs)):
        named = [(f"{key}: {entry}", item) for entry, node in entries.items() for item in items(node)]
        found += [(text, item.place) for text, item in named if (sender(item) or ("",))[0] == name]
    return found
