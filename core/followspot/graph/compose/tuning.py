"""`tune` of a room for parameters of sub-graphs: `hall.similarity: 0.85`, as `--set` gives them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from followspot.graph.override import Override
from followspot.yaml.node import Node, child


def subgraph_tunes(room: Node | None) -> Iterator[Override]:
    """The tunes of a room document that may name a sub-graph: all but those of plugins."""
    entries = child(room, "tune")
    if entries is None or not isinstance(entries.value, Mapping):
        return
    for key, node in entries.value.items():
        subject, _, parameter = key.rpartition(".")
        if subject and "." not in subject:
            yield Override(subject, ("with", parameter), (node.key, node.key), node, node.key, tune=True)
