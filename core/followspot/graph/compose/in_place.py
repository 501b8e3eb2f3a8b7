"""A graph file in the place of another that a running graph uses as a stage."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from followspot.errors import Mistake
from followspot.graph.compose.belonging import seen_only
from followspot.graph.compose.compose import outputs_below, stages_of, units_below
from followspot.graph.compose.fan_out import Use
from followspot.graph.compose.graph_file import GraphFile, GraphFiles
from followspot.graph.compose.interface import Interface, read_interface
from followspot.graph.compose.interface_targets import StageTarget, check_nested, stage_targets
from followspot.graph.compose.narrowing import Limit
from followspot.graph.compose.optional_use import OptionalUse, left_out_below, optional_uses
from followspot.graph.compose.resolved import resolved, resolved_uses
from followspot.graph.compose.tuning import subgraph_tunes
from followspot.graph.compose.unit import Unit
from followspot.graph.compose.unit_builder import UnitBuilder
from followspot.graph.override import SUBGRAPH, overridden
from followspot.graph.selector import read_selector
from followspot.graph.subgraph_use import SubgraphUse
from followspot.room import Room
from followspot.yaml.form import Form
from followspot.yaml.node import Node, node_of


@dataclass(frozen=True)
class InPlace:
    """The content of a sub-graph after its file was exchanged for another.

    stages: by full name; outputs: of the sub-graph and of those inside it, SUBGRAPH.NAME, each with the feeds
    of its readers; left_out, optional: see `LoadedGraph`.
    """

    stages: Mapping[str, Node]
    outputs: Mapping[str, tuple[Node, ...]]
    left_out: Mapping[str, Mistake]
    optional: tuple[OptionalUse, ...]
    subgraphs: tuple[SubgraphUse, ...]
    interface_targets: tuple[StageTarget, ...]


def in_place(
    file: Node,
    use: SubgraphUse,
    given: Mapping[str, Node],
    changed: Mapping[str, Node],
    around: Mapping[str, Node],
    room: Room,
    document: Node | None,
    mistakes: list[Mistake],
) -> InPlace | None:
    """The file in the place of a use; None if mistakes leave its stages unknown.

    file: its path; given: parameters of the interface; changed: those that a change gave, of which the file
    gets what its interface has; around: entries of the other stages of the graph; document: of the room, for
    its tunes.
    """
    before = len(mistakes)
    parent = Unit("", GraphFile("", file.place, ()), Interface({}, {}, {}), {})
    builder = UnitBuilder(GraphFiles(mistakes, mistakes), room, True, mistakes, mistakes)
    tunes = list(subgraph_tunes(document))
    entry = _entry(file, use, {**given, **_known(file, use, changed)})
    for tune in (tune for name in reversed(use.names) for tune in tunes if tune.stage == name):
        entry = overridden(entry, tune, mistakes)
    form = Form(entry, f'sub-graph "{use.name}"', SUBGRAPH, mistakes)
    inside = [tune for tune in tunes if use.holds(tune.stage)]
    found = list(builder.used(parent, use.stage, Use(use.name, _limits(use, file), False), form, inside))
    if len(mistakes) > before or not found:
        return None
    (unit,) = found
    stages = dict(stages_of(unit, mistakes))
    check_nested(unit, mistakes)
    own = resolved(unit, use.stage)
    own = replace(own, inputs=use.inputs, given={**use.given, **own.given})
    uses = (own, *resolved_uses(unit))
    below = seen_only({**around, **stages}, [unit, *units_below(unit)])
    inner = {name: below[name] for name in stages}
    parent.units[use.name] = (unit,)
    return InPlace(
        stages=inner,
        outputs=outputs_below(parent),
        left_out=left_out_below(unit),
        optional=tuple(optional_uses(unit)),
        subgraphs=uses,
        interface_targets=stage_targets(unit),
    )


def _entry(file: Node, use: SubgraphUse, given: Mapping[str, Node]) -> Node:
    """The entry of a stage that uses the file, with the inputs of the use and these parameters."""
    entries = {
        "graph": file,
        "in": node_of(dict(use.inputs), file.place),
        "with": Node(given, file.place, file.key),
    }
    return Node(entries, file.place, file.key)


def _known(file: Node, use: SubgraphUse, changed: Mapping[str, Node]) -> dict[str, Node]:
    """The values that the interface of the file passes on to stages that stay in it."""
    read = GraphFiles([], []).used(file, "graph", (), file.key)
    if read is None:
        return {}
    interface = read_interface(read, [])
    replaced = {
        target.stage
        for name in use.inputs
        for target in interface.inputs.get(name, ())
        if target.name is None
    }
    return {
        name: node
        for name, node in changed.items()
        if (targets := interface.params.get(name)) and not replaced & {target.stage for target in targets}
    }


def _limits(use: SubgraphUse, file: Node) -> tuple[Limit, ...]:
    texts: Iterable[Node] = (Node(text, file.place, file.key) for text in use.cameras)
    return (*(read_selector(text, []) for text in texts), *use.members)
