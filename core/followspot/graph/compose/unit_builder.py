"""Builds the units of one graph: a unit for the graph itself, and one for each use of a sub-graph in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from followspot.errors import Mistake, Place
from followspot.graph.compose.fan_out import Use, UseContext, fan_out
from followspot.graph.compose.graph_file import GraphFile, GraphFiles
from followspot.graph.compose.interface import read_interface
from followspot.graph.compose.interface_use import apply_use
from followspot.graph.compose.removed import check_removed
from followspot.graph.compose.unit import Unit, WiredInput
from followspot.graph.names import below
from followspot.graph.override import SUBGRAPH, Override, overridden
from followspot.room import Room
from followspot.yaml.form import Form
from followspot.yaml.node import Node


class UnitBuilder:
    """Builds the units of one graph, and notes mistakes about its interface."""

    def __init__(
        self,
        files: GraphFiles,
        room: Room | None,
        named: bool,
        mistakes: list[Mistake],
        minor: list[Mistake],
    ) -> None:
        """room: None if it has mistakes; named: whether the graph names one.

        mistakes: receives those that leave stages or edges of the graph unknown; minor: the others.
        """
        self.files = files
        self.room = room
        self.named = named
        self.mistakes = mistakes
        self.minor = minor
        self.unknown: list[Override] = []
        self.tuned: set[Place] = set()
        """Places of the tunes that name a sub-graph."""

    def root(self, file: GraphFile, overrides: Sequence[Override]) -> Unit:
        """The graph itself with all sub-graphs below it."""
        unit = self._unit("", file)
        self._complete(unit, overrides)
        return unit

    def _unit(self, name: str, file: GraphFile) -> Unit:
        check_removed(file, self.mistakes)
        return Unit(name, file, read_interface(file, self.mistakes), dict(file.stages))

    def _complete(self, unit: Unit, overrides: Sequence[Override]) -> None:
        """Apply overrides, and add the units below."""
        left = [override for override in overrides if not self._apply(unit, override)]
        for stage, node in unit.stages.items():
            if _is_subgraph(node) and stage not in unit.replaced:
                inside = [override for override in left if override.stage.startswith(f"{stage}/")]
                left = [override for override in left if override not in inside]
                unit.units[stage] = tuple(self._below(unit, stage, node, inside))
        self.unknown += left

    def _below(self, parent: Unit, stage: str, node: Node, overrides: Sequence[Override]) -> Iterator[Unit]:
        """The units of a stage that is a sub-graph: one, or one for each member that it fans out over."""
        entry = Form(node, f'sub-graph "{below(parent.name, stage)}"', SUBGRAPH, self.mistakes)
        around = UseContext(self.room, self.named, parent.name, parent.limits)
        found = fan_out(stage, entry, around, self.mistakes)
        parent.left_out |= found.left_out
        if stage in found.left_out:
            self._set_apart(parent, stage, entry, overrides)
        if [use.name for use in found.uses] == [stage]:
            yield from self.used(parent, stage, found.uses[0], entry, overrides if found.complete else ())
            return
        names = [*(use.name for use in found.uses), *found.left_out]
        self.unknown += [o for o in overrides if not any(f"{o.stage}/".startswith(f"{n}/") for n in names)]
        for use in found.uses:
            own = self._member_entry(node, stage, use.name, overrides)
            entry = Form(own, f'sub-graph "{below(parent.name, use.name)}"', SUBGRAPH, [])  # noted above
            mine = [override for override in overrides if override.stage.startswith(f"{use.name}/")]
            yield from self.used(parent, stage, use, entry, mine)

    def _set_apart(self, parent: Unit, stage: str, entry: Form, overrides: Sequence[Override]) -> None:
        """Make the unit of a sub-graph that is left out as if its room were not known, for its mistakes."""
        builder = UnitBuilder(self.files, None, self.named, self.mistakes, self.minor)
        use = Use(stage, parent.limits, optional=True)
        inside = overrides if entry.get("each") is None else ()
        for unit in builder.used(parent, stage, use, entry, inside):
            parent.apart[stage] = unit
        self.unknown += builder.unknown
        self.tuned |= builder.tuned

    def _member_entry(self, node: Node, stage: str, name: str, overrides: Sequence[Override]) -> Node:
        """The entry of one member of a sub-graph, with the overrides for this member alone."""
        for override in (override for override in overrides if override.stage == name):
            node = overridden(node, override, self.minor)
            if override.tune:
                self.tuned.add(override.stage_place)
            if override.keys[0] in ("each", "cameras", "optional"):
                text = f'"{name}" is one member of a sub-graph; {override.keys[0]} is the same for all'
                remedy = f"write {stage}.{override.keys[0]}=..."
                self.mistakes.append(Mistake(override.stage_place, text, remedy))
        return node

    def used(
        self, parent: Unit, stage: str, use: Use, entry: Form, overrides: Sequence[Override]
    ) -> Iterator[Unit]:
        """The unit of one use of a file; none if a mistake was noted."""
        file = self.files.used(entry.entries["graph"], "graph", parent.file.paths, entry.node.key)
        if file is None:
            return
        wired = {port: found for (to, port), found in parent.wired.items() if to == stage}
        unit = replace(
            self._unit(below(parent.name, use.name), file),
            limits=use.limits,
            optional=entry.node.key if use.optional else None,
            inputs={**_own_inputs(entry, parent), **wired},
            given=entry.mapping("with"),
        )
        apply_use(unit, self.mistakes)
        self._complete(unit, [override.below(use.name) for override in overrides])
        yield unit

    def _apply(self, unit: Unit, override: Override) -> bool:
        """Apply an override if it is for a stage of this unit."""
        stage = override.stage
        if stage not in unit.stages or (override.tune and not _is_subgraph(unit.stages[stage])):
            return False
        if override.tune:
            self.tuned.add(override.stage_place)
        if stage in unit.replaced and not override.tune:
            text = f'stage "{below(unit.name, stage)}" is replaced by an input of its sub-graph'
            place = override.stage_place.within(unit.replaced[stage].feeds.place)
            self.mistakes.append(Mistake(place, text, "set the stage that feeds this input"))
        else:
            unit.stages[stage] = overridden(unit.stages[stage], override, self.minor)
        return True


def _own_inputs(entry: Form, parent: Unit) -> dict[str, WiredInput]:
    """The inputs that the stage connects, in the names of the unit around it."""
    return {name: WiredInput(parent, feeds) for name, feeds in entry.mapping("in").items()}


def _is_subgraph(node: Node) -> bool:
    """True if the entry of a stage names a graph file."""
    return isinstance(node.value, Mapping) and "graph" in node.value
