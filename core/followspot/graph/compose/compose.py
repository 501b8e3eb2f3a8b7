"""One flat mapping of stages from a graph file, the files that it extends and its sub-graphs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.compose.belonging import belonging, seen_only
from followspot.graph.compose.feeds import items, origin
from followspot.graph.compose.graph_file import GraphFiles
from followspot.graph.compose.interface_targets import StageTarget, check_nested, stage_targets
from followspot.graph.compose.narrowing import narrowed
from followspot.graph.compose.optional_use import OptionalUse, left_out_below, optional_uses
from followspot.graph.compose.resolved import resolved_uses
from followspot.graph.compose.senders import senders
from followspot.graph.compose.tuning import subgraph_tunes
from followspot.graph.compose.unit import Unit, WiredInput
from followspot.graph.compose.unit_builder import UnitBuilder
from followspot.graph.names import below
from followspot.graph.override import Override
from followspot.graph.subgraph_use import SubgraphUse
from followspot.room import Room
from followspot.yaml.node import Node, child


@dataclass(frozen=True)
class ComposedGraph:
    """A graph without sub-graphs, as if it were one file.

    room: the value of the key; place: of the graph file; files: all that were read; complete: False if a
    mistake in how files are put together left stages or edges unknown; offered: stages that an interface
    names among its outputs.
    """

    name: str
    place: Place
    room: Node | None
    seed: int
    stages: Mapping[str, Node]
    files: tuple[Path, ...]
    complete: bool
    offered: frozenset[str] = frozenset()
    interface_targets: tuple[StageTarget, ...] = ()
    """The targets that the interface of the graph file itself names."""
    left_out: Mapping[str, Mistake] = field(default_factory=dict)
    """The sub-graphs that the room has nothing for, with the reasons; feeds still name them."""
    apart: Mapping[str, Node] = field(default_factory=dict)
    """The stages of these."""
    optional: tuple[OptionalUse, ...] = ()
    """The other sub-graphs that may be left out."""
    tuned: frozenset[Place] = frozenset()
    """Of the tunes of the room that set parameters of sub-graphs."""
    outputs: Mapping[str, tuple[Node, ...]] = field(default_factory=dict)
    """The outputs of sub-graphs, SUBGRAPH.NAME, each with what feeds a reader of it."""
    subgraphs: tuple[SubgraphUse, ...] = ()


def compose(
    path: Path,
    overrides: Sequence[Override],
    find_room: Callable[[Node | None], tuple[Room | None, Node | None]],
    mistakes: list[Mistake],
) -> ComposedGraph:
    """Put the files of a graph together, with overrides; note mistakes.

    find_room: gives the room and its document from what the graph says; see `LoadedGraph`. Raises InputError
    if the graph file itself cannot be read.
    """
    wrong: list[Mistake] = []
    files = GraphFiles(wrong, mistakes)
    root = files.root(path)
    room, document = find_room(root.room)
    builder = UnitBuilder(files, room, document is not None, wrong, mistakes)
    unit = builder.root(root, [*(subgraph_tunes(document) if room is not None else ()), *overrides])
    stages = _distinct(stages_of(unit, wrong), wrong)
    for override in (found for found in builder.unknown if not found.tune):
        name = below(override.within, override.stage)
        known = {*stages, *(found.name for found in units_below(unit))}
        mistakes.append(_no_stage(name, override, stages, known))
    check_nested(unit, wrong)
    apart = dict(_apart(unit, wrong))
    mistakes += wrong
    stages = seen_only(stages, units_below(unit))
    return ComposedGraph(
        name=root.name,
        place=root.place,
        room=root.room,
        seed=root.seed or 0,
        stages=stages,
        files=tuple(files.files),
        complete=not wrong,
        offered=_offered(unit) if not wrong else frozenset(),
        interface_targets=stage_targets(unit),
        left_out=left_out_below(unit),
        apart=apart,
        optional=tuple(optional_uses(unit)) if not wrong else (),
        tuned=frozenset(builder.tuned),
        outputs=outputs_below(unit) if not wrong else {},
        subgraphs=tuple(resolved_uses(unit)) if not wrong else (),
    )


def _distinct(stages: Iterable[tuple[str, Node]], mistakes: list[Mistake]) -> dict[str, Node]:
    """The stages by name, the first of each; notes those of the same name."""
    found: dict[str, Node] = {}
    for name, node in stages:
        if name in found:
            place = node.key.beside(found[name].key)
            mistakes.append(Mistake(place, f'stage "{name}" is declared twice', "rename one"))
        found.setdefault(name, node)
    return found


def _no_stage(name: str, override: Override, stages: Mapping[str, Node], known: Collection[str]) -> Mistake:
    """The mistake of an option for a stage that the graph lacks; one for an instance says how to give it."""
    group, _, member = name.rpartition("/")
    if group in stages and child(stages[group], "each") is not None:
        key = ".".join(override.keys)
        text = f'"{name}" is an instance of stage "{group}", and --set reaches all instances of a stage'
        remedy = f"write {group}.{key}=VALUE; for {member} alone the room says tune: {{{name}.{key}: VALUE}}"
        return Mistake(override.stage_place, text, remedy)
    return Mistake(
        override.stage_place, f'the graph has no stage "{name}"', did_you_mean(name, known, "stages")
    )


def outputs_below(unit: Unit) -> dict[str, tuple[Node, ...]]:
    """The outputs of the sub-graphs below a unit; of one that fans out those of all members, too.

    Those of sub-graphs that are left out are among them.
    """
    found: dict[str, tuple[Node, ...]] = {}
    for stage, inners in unit.units.items():
        for inner in inners:
            for name, feeds in _outputs(inner):
                for full in dict.fromkeys((below(unit.name, stage), inner.name)):
                    found[f"{full}.{name}"] = (*found.get(f"{full}.{name}", ()), *feeds)
            found |= outputs_below(inner)
    for stage, left_out in unit.apart.items():
        found |= {f"{below(unit.name, stage)}.{name}": feeds for name, feeds in _outputs(left_out)}
        found |= outputs_below(left_out)
    return found


def _outputs(unit: Unit) -> Iterator[tuple[str, tuple[Node, ...]]]:
    """The outputs of a sub-graph, each with what feeds a reader of it."""
    for name, targets in unit.interface.outputs.items():
        yield name, tuple(node for target in targets for node in senders(unit, target.node, []))


def _offered(unit: Unit) -> frozenset[str]:
    """Full names of the stages that interfaces offer, that of the graph file included."""
    found = [
        str(origin(node).value)
        for one in (unit, *units_below(unit))
        for targets in one.interface.outputs.values()
        for target in targets
        for node in senders(one, target.node, [])
    ]
    return frozenset(name.partition(".")[0] for name in found)


def units_below(unit: Unit) -> Iterator[Unit]:
    """All sub-graphs."""
    for inner in (inner for found in unit.units.values() for inner in found):
        yield inner
        yield from units_below(inner)


def stages_of(unit: Unit, mistakes: list[Mistake]) -> Iterator[tuple[str, Node]]:
    """The stages of a unit and of those below it, in the order of the files, with full names."""
    for name, node in unit.stages.items():
        if name in unit.units:
            for inner in unit.units[name]:
                yield from stages_of(inner, mistakes)
        elif name not in unit.replaced:
            yield below(unit.name, name), _flat(name, node, unit, mistakes)


def _apart(unit: Unit, mistakes: list[Mistake]) -> Iterator[tuple[str, Node]]:
    """The stages of all sub-graphs that are left out, with full names."""
    for one in (unit, *units_below(unit)):
        for left_out in one.apart.values():
            yield from stages_of(left_out, mistakes)


def _flat(name: str, node: Node, unit: Unit, mistakes: list[Mistake]) -> Node:
    """The entry of a stage with full names of its senders and the selectors around it."""
    if not isinstance(node.value, Mapping):
        return node
    entry = dict(node.value)
    if "each" in entry:
        entry["each"] = narrowed(entry["each"], unit.limits)
    entry = belonging(entry, node, unit.limits)
    inputs = entry.get("in")
    wired = {port: found for (stage, port), found in unit.wired.items() if stage == name}
    if wired and inputs is None:
        inputs = Node({}, node.place, node.key)
    if inputs is not None and isinstance(inputs.value, Mapping):
        own = {port: WiredInput(unit, feeds) for port, feeds in inputs.value.items()}
        value = {port: _feeds(found, mistakes) for port, found in {**own, **wired}.items()}
        entry["in"] = replace(inputs, value=value)
    return replace(node, value=entry)


def _feeds(wired: WiredInput, mistakes: list[Mistake]) -> Node:
    """The feeds of an input, with full names."""
    found = [one for item in items(wired.feeds) for one in senders(wired.unit, item, mistakes)]
    if not isinstance(wired.feeds.value, tuple) and len(found) == 1:
        return replace(found[0], key=wired.feeds.key)
    return replace(wired.feeds, value=tuple(found))
