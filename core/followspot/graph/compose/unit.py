"""A graph file in use: the graph itself, or a sub-graph of it with its parameters and inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from followspot.document import Node
from followspot.errors import Mistake, Place, did_you_mean
from followspot.form import Form
from followspot.graph.compose.feeds import items, sender
from followspot.graph.compose.graph_file import GraphFile, GraphFiles
from followspot.graph.compose.interface import Interface, Target, read_interface
from followspot.graph.compose.narrowing import check_cameras
from followspot.graph.names import below
from followspot.graph.override import SUBGRAPH, Override, overridden, with_value


@dataclass(frozen=True)
class Wired:
    """What feeds an input; unit: in whose names the feeds are written."""

    unit: Unit
    feeds: Node


@dataclass
class Unit:
    """One use of a graph file.

    name: of the sub-graph, "" for the graph itself; stages: as in the file, with the parameters that the use
    gives; wired: inputs of these stages that the use connects; replaced: stages in whose place the use
    connects something; cameras: selectors of the use and of the uses around it; units: the sub-graphs among
    the stages.
    """

    name: str
    file: GraphFile
    interface: Interface
    stages: dict[str, Node]
    cameras: tuple[Node, ...] = ()
    wired: dict[tuple[str, str], Wired] = field(default_factory=dict)
    replaced: dict[str, Wired] = field(default_factory=dict)
    units: dict[str, Unit] = field(default_factory=dict)


class Units:
    """Makes the units of one graph, and notes what does not fit an interface."""

    def __init__(self, files: GraphFiles, mistakes: list[Mistake], odd: list[Mistake]) -> None:
        """mistakes, odd: lists that receive mistakes, odd those with which the graph is still known."""
        self.files = files
        self.mistakes = mistakes
        self.odd = odd
        self.unknown: list[Override] = []

    def unit(
        self,
        file: GraphFile,
        overrides: Sequence[Override],
        name: str = "",
        entry: Form | None = None,
        parent: Unit | None = None,
    ) -> Unit:
        """The unit of a file with all that are below it; entry: the stage that uses the file."""
        self._check_removed(file)
        unit = Unit(name, file, read_interface(file, self.mistakes), dict(file.stages))
        if entry is not None and parent is not None:
            unit.cameras = (*parent.cameras, *self._cameras(entry))
            self._connect(unit, {**_own_inputs(entry, parent), **_wired_inputs(name, parent)})
            self._give_params(unit, entry)
        left = [override for override in overrides if not self._apply(unit, override)]
        for stage, node in unit.stages.items():
            if _is_subgraph(node) and stage not in unit.replaced:
                inside = [override for override in left if override.stage.startswith(f"{stage}/")]
                left = [override for override in left if override not in inside]
                self._add(unit, stage, node, [override.below(stage) for override in inside])
        self.unknown += left
        return unit

    def _cameras(self, entry: Form) -> Sequence[Node]:
        """The selector below `cameras`, if there is one."""
        found = entry.get("cameras")
        if found is not None:
            check_cameras(found, self.mistakes)
        return () if found is None else (found,)

    def _apply(self, unit: Unit, override: Override) -> bool:
        """Apply an override if it is for a stage of this unit."""
        stage = override.stage
        if stage not in unit.stages:
            return False
        if stage in unit.replaced:
            text = f'stage "{below(unit.name, stage)}" is replaced by an input of its sub-graph'
            place = override.stage_place.within(unit.replaced[stage].feeds.place)
            self.mistakes.append(Mistake(place, text, "set the stage that feeds this input"))
        else:
            unit.stages[stage] = overridden(unit.stages[stage], override, self.odd)
        return True

    def _add(self, parent: Unit, stage: str, node: Node, overrides: Sequence[Override]) -> None:
        """Add the unit of a stage that is a sub-graph."""
        entry = Form(node, f'sub-graph "{below(parent.name, stage)}"', SUBGRAPH, self.mistakes)
        file = self.files.used(entry.entries["graph"], "graph", parent.file.paths, node.key)
        if file is not None:
            parent.units[stage] = self.unit(file, overrides, below(parent.name, stage), entry, parent)

    def _check_removed(self, file: GraphFile) -> None:
        """Note removed stages that others still read, or the interface names."""
        for name, place in file.removed.items():
            readers = [*_readers(name, file)]
            if not readers:
                continue
            listed = ", ".join(dict.fromkeys(reader for reader, _ in readers))
            text = f'stage "{name}" is removed, but read by: {listed}'
            remedy = "feed them from another stage, or remove them too"
            self.mistakes.append(Mistake(_seen_with(place, readers[0][1]), text, remedy))

    def _connect(self, unit: Unit, inputs: Mapping[str, Wired]) -> None:
        """Connect inputs of the interface."""
        by: dict[tuple[str, str | None], str] = {}
        for name, wired in inputs.items():
            targets = unit.interface.inputs.get(name)
            if targets is None:
                self._unknown(unit, "input", name, wired.feeds.key, unit.interface.inputs)
            elif not items(wired.feeds):
                text = f'input "{name}" of sub-graph "{unit.name}" is fed by nothing'
                self.mistakes.append(Mistake(wired.feeds.place, text, "name a stage"))
            for target in targets or ():
                first = by.setdefault((target.stage, target.name), name)
                if first != name or (target.name is not None and target.stage in unit.replaced):
                    text = (
                        f'several inputs of sub-graph "{unit.name}" feed "{target.text}": connect one of them'
                    )
                    self._wrong(wired.feeds.key, target, text, f'"{first}" feeds it, too')
                elif target.name is None:
                    unit.replaced[target.stage] = wired
                else:
                    unit.wired[target.stage, target.name] = wired

    def _give_params(self, unit: Unit, entry: Form) -> None:
        """Put the values below `with` where the interface says."""
        for name, value in entry.mapping("with").items():
            targets = unit.interface.params.get(name)
            if targets is None:
                self._unknown(unit, "parameter", name, value.key, unit.interface.params)
            for target in targets or ():
                key, place = (_seen_with(place, target.node.place) for place in (value.key, value.place))
                keys = ("with", *(target.name or "").split("."))
                if target.stage in unit.replaced:
                    text = f'parameter "{name}" of sub-graph "{unit.name}" sets "{target.text}"'
                    self._wrong(
                        value.key, target, text, "this stage is replaced by an input: remove the value"
                    )
                else:
                    found = replace(value, place=place)
                    entry_of = unit.stages[target.stage]
                    unit.stages[target.stage] = with_value(entry_of, keys, (key,) * len(keys), found)

    def _wrong(self, place: Place, target: Target, text: str, remedy: str) -> None:
        """Note a mistake at a use of an interface, together with the place of the interface."""
        self.mistakes.append(Mistake(_seen_with(place, target.node.place), text, remedy))

    def _unknown(self, unit: Unit, noun: str, name: str, place: Place, known: Mapping[str, object]) -> None:
        text = f'graph "{unit.file.name}", used as "{unit.name}", has no {noun} "{name}"'
        remedy = did_you_mean(name, known.keys(), f"{noun}s")
        self.mistakes.append(Mistake(_seen_with(place, unit.file.place), text, remedy))


def _is_subgraph(node: Node) -> bool:
    return isinstance(node.value, Mapping) and "graph" in node.value


def _own_inputs(entry: Form, parent: Unit) -> dict[str, Wired]:
    """The inputs that the stage connects, in the names of the unit around it."""
    return {name: Wired(parent, feeds) for name, feeds in entry.mapping("in").items()}


def _wired_inputs(name: str, parent: Unit) -> dict[str, Wired]:
    """The inputs that an interface around the sub-graph connects."""
    stage = name.removeprefix(f"{parent.name}/")
    return {port: wired for (to, port), wired in parent.wired.items() if to == stage}


def _seen_with(place: Place, other: Place) -> Place:
    """The place together with another one that matters, without the outer places of that."""
    return place.within(replace(other, outer=None))


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
