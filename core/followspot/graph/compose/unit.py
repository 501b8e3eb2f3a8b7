"""A graph file in use: the graph itself, or a sub-graph of it with its parameters and inputs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from followspot.document import Node
from followspot.errors import Mistake, Place, did_you_mean
from followspot.form import Form
from followspot.graph.compose.fan_out import Use, UseContext, fan_out
from followspot.graph.compose.feeds import items
from followspot.graph.compose.graph_file import GraphFile, GraphFiles
from followspot.graph.compose.interface import SECTION, Interface, InterfaceTarget, read_interface
from followspot.graph.compose.narrowing import Limit
from followspot.graph.compose.removed import check_removed
from followspot.graph.names import below
from followspot.graph.override import SUBGRAPH, Override, overridden, with_value
from followspot.room import Room


@dataclass(frozen=True)
class Wired:
    """What feeds an input; unit: in whose names the feeds are written."""

    unit: Unit
    feeds: Node


@dataclass
class Unit:
    """One use of a graph file.

    name: of the sub-graph, "" for the graph itself; stages: as in the file, with the parameters that the use
    gives; wired: inputs of these stages that the use connects; replaced: stages that a connected input of
    the interface replaces; limits: the cameras or members that the use, and those around it, serve; units:
    the sub-graphs among the stages, several for one that fans out.
    """

    name: str
    file: GraphFile
    interface: Interface
    stages: dict[str, Node]
    limits: tuple[Limit, ...] = ()
    wired: dict[tuple[str, str], Wired] = field(default_factory=dict)
    replaced: dict[str, Wired] = field(default_factory=dict)
    units: dict[str, tuple[Unit, ...]] = field(default_factory=dict)
    left_out: dict[str, Mistake] = field(default_factory=dict)
    """The optional sub-graphs whose cameras or members the room lacks, by name, with the reasons."""
    apart: dict[str, Unit] = field(default_factory=dict)
    """The units of these, made as if the room was unknown, so that their files are checked all the same."""
    optional: Place | None = None
    """The place of `optional: true` in the use; None for a use that may not be left out."""
    inputs: Mapping[str, Wired] = field(default_factory=dict)
    """The inputs of the interface that the use connects."""
    given: Mapping[str, Node] = field(default_factory=dict)
    """The parameters of the interface that the use gives."""


class Units:
    """Makes the units of one graph, and notes what does not fit an interface."""

    def __init__(
        self,
        files: GraphFiles,
        room: Room | None,
        named: bool,
        mistakes: list[Mistake],
        odd: list[Mistake],
    ) -> None:
        """room: None if it has mistakes; named: whether the graph names one; mistakes, odd: lists that
        receive mistakes, odd those with which the graph is still known.
        """
        self.files = files
        self.room = room
        self.named = named
        self.mistakes = mistakes
        self.odd = odd
        self.unknown: list[Override] = []
        self.tuned: set[Place] = set()
        """Of the tunes that name a sub-graph."""

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
            if is_subgraph(node) and stage not in unit.replaced:
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
            own = self._own(node, stage, use.name, overrides)
            entry = Form(own, f'sub-graph "{below(parent.name, use.name)}"', SUBGRAPH, [])  # noted above
            mine = [override for override in overrides if override.stage.startswith(f"{use.name}/")]
            yield from self.used(parent, stage, use, entry, mine)

    def _set_apart(self, parent: Unit, stage: str, entry: Form, overrides: Sequence[Override]) -> None:
        """Make the unit of a sub-graph that is left out as if its room were not known, for its mistakes."""
        units = Units(self.files, None, self.named, self.mistakes, self.odd)
        use = Use(stage, parent.limits, optional=True)
        inside = overrides if entry.get("each") is None else ()
        for unit in units.used(parent, stage, use, entry, inside):
            parent.apart[stage] = unit
        self.unknown += units.unknown
        self.tuned |= units.tuned

    def _own(self, node: Node, stage: str, name: str, overrides: Sequence[Override]) -> Node:
        """The entry of one member of a sub-graph, with the overrides for this member alone."""
        for override in (override for override in overrides if override.stage == name):
            node = overridden(node, override, self.odd)
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
        self._connect(unit, unit.inputs)
        self._give_params(unit)
        self._complete(unit, [override.below(use.name) for override in overrides])
        yield unit

    def _apply(self, unit: Unit, override: Override) -> bool:
        """Apply an override if it is for a stage of this unit."""
        stage = override.stage
        if stage not in unit.stages or (override.tune and not is_subgraph(unit.stages[stage])):
            return False
        if override.tune:
            self.tuned.add(override.stage_place)
        if stage in unit.replaced and not override.tune:
            text = f'stage "{below(unit.name, stage)}" is replaced by an input of its sub-graph'
            place = override.stage_place.within(unit.replaced[stage].feeds.place)
            self.mistakes.append(Mistake(place, text, "set the stage that feeds this input"))
        else:
            unit.stages[stage] = overridden(unit.stages[stage], override, self.odd)
        return True

    def _connect(self, unit: Unit, inputs: Mapping[str, Wired]) -> None:
        """Connect inputs of the interface."""
        connected: list[tuple[InterfaceTarget, str]] = []
        for name, wired in inputs.items():
            targets = unit.interface.inputs.get(name)
            if targets is None:
                self._unknown(unit, "input", name, wired.feeds.key, unit.interface.inputs)
            elif not items(wired.feeds):
                text = f'input "{name}" of sub-graph "{unit.name}" is fed by nothing'
                self.mistakes.append(Mistake(wired.feeds.place, text, "name a stage"))
            else:
                for target in targets:
                    self._connect_to(unit, target, name, wired, connected)

    def _connect_to(
        self,
        unit: Unit,
        target: InterfaceTarget,
        name: str,
        wired: Wired,
        connected: list[tuple[InterfaceTarget, str]],
    ) -> None:
        """Connect an input to one of its targets, unless one of those connected before has taken it."""
        first = next((other for known, other in connected if _overlap(known, target)), None)
        if first is not None:
            both = f'"{first}" and "{name}" of sub-graph "{unit.name}"'
            self._wrong(
                wired.feeds.key, target, f"inputs {both} both feed {target.stage}", "connect one of them"
            )
        elif target.name is None:
            unit.replaced[target.stage] = wired
        else:
            key = wired.feeds.key.beside(target.node.place)
            unit.wired[target.stage, target.name] = replace(wired, feeds=replace(wired.feeds, key=key))
        connected.append((target, name))

    def _give_params(self, unit: Unit) -> None:
        """Put the values below `with` where the interface says."""
        by: dict[tuple[str, str | None], str] = {}
        for name, value in unit.given.items():
            targets = unit.interface.params.get(name)
            if targets is None:
                self._unknown(unit, "parameter", name, value.key, unit.interface.params)
            for target in targets or ():
                key, place = (place.beside(target.node.place) for place in (value.key, value.place))
                keys = ("with", *(target.name or "").split("."))
                first = by.setdefault((target.stage, target.name), name)
                if first != name:
                    both = f'"{first}" and "{name}" of sub-graph "{unit.name}"'
                    text = f"parameters {both} both set {target.text}"
                    self._wrong(value.key, target, text, "give one of them")
                elif target.stage in unit.replaced:
                    text = f'parameter "{name}" of sub-graph "{unit.name}" sets "{target.text}"'
                    self._wrong(
                        value.key, target, text, "this stage is replaced by an input: remove the value"
                    )
                else:
                    found = replace(value, place=place)
                    entry_of = unit.stages[target.stage]
                    unit.stages[target.stage] = with_value(entry_of, keys, (key,) * len(keys), found)

    def _wrong(self, place: Place, target: InterfaceTarget, text: str, remedy: str) -> None:
        """Note a mistake at a use of an interface, together with the place of the interface."""
        self.mistakes.append(Mistake(place.beside(target.node.place), text, remedy))

    def _unknown(self, unit: Unit, noun: str, name: str, place: Place, known: Mapping[str, object]) -> None:
        if SECTION[noun] in unit.file.unreadable:
            return
        text = f'graph "{unit.file.name}", used as "{unit.name}", has no {noun} "{name}"'
        remedy = did_you_mean(name, known.keys(), f"{noun}s")
        self.mistakes.append(Mistake(place.beside(unit.file.place), text, remedy))


def is_subgraph(node: Node) -> bool:
    """True if the entry of a stage names a graph file."""
    return isinstance(node.value, Mapping) and "graph" in node.value


def _overlap(first: InterfaceTarget, second: InterfaceTarget) -> bool:
    """True if both stand for one port, or one for the stage of the other."""
    return first.stage == second.stage and (first.name == second.name or None in (first.name, second.name))


def _own_inputs(entry: Form, parent: Unit) -> dict[str, Wired]:
    """The inputs that the stage connects, in the names of the unit around it."""
    return {name: Wired(parent, feeds) for name, feeds in entry.mapping("in").items()}
