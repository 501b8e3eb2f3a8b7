"""The flow of messages through a checked graph: its stages, its edges, and their order."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from followspot.graph.connections import CheckedEdge
from followspot.graph.cycles import Successors, successors, topological
from followspot.graph.instances import CheckedStage

_FIRING = ("plain", "joined")
"""Kinds of inputs whose messages let a stage fire."""


@dataclass(frozen=True)
class Flow:
    """The checked stages, and all edges by the instances at their ends."""

    stages: Mapping[str, CheckedStage]
    edges: Sequence[CheckedEdge]

    @cached_property
    def after(self) -> Successors:
        """The instances that each instance feeds, without sampled and delayed edges."""
        ends = [(e.wire.source.name, e.wire.target.name) for e in self.edges if not e.held]
        return successors(self.stages, ends)

    @cached_property
    def order(self) -> Sequence[str]:
        """All instances in topological order."""
        return topological(self.after)

    @cached_property
    def firing_edges(self) -> Mapping[str, Sequence[CheckedEdge]]:
        """The edges into each instance whose messages let it fire: neither sampled nor delayed."""
        found: dict[str, list[CheckedEdge]] = {name: [] for name in self.stages}
        for edge in self.edges:
            if edge.kind in _FIRING and not edge.held:
                found[edge.wire.target.name].append(edge)
        return found

    @cached_property
    def groups(self) -> Mapping[str, list[CheckedStage]]:
        """The instances of each stage of the graph file."""
        found: dict[str, list[CheckedStage]] = defaultdict(list)
        for checked in self.stages.values():
            found[checked.instance.declared.name].append(checked)
        return found
