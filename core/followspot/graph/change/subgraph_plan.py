"""A graph file in the place of a sub-graph of a plan: its instances, their parameters and their edges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from followspot.errors import Mistake, Place
from followspot.graph.checks.inputs import check_inputs
from followspot.graph.checks.interfaces import check_interface
from followspot.graph.compose.in_place import InPlace, in_place
from followspot.graph.connections import CheckedEdge, connect
from followspot.graph.declaration import ROOM_SOURCE, StageDeclaration, read_stage
from followspot.graph.expand import ExpandedGraph, expand
from followspot.graph.instances import CheckedStage, Instance
from followspot.graph.load import LoadedGraph
from followspot.graph.override import WHILE_IT_RAN
from followspot.graph.parameters import validated
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.selector import Condition, Selector
from followspot.graph.subgraph_ports import subgraph_ports
from followspot.graph.subgraph_use import SubgraphUse
from followspot.graph.tune import tuned_graph
from followspot.plugins.registry import PluginError, load_stage
from followspot.stage import Stage
from followspot.yaml.node import Node, node_of

GIVEN = "(given by the graph)"
"""File of the places of values that the use of a file passes on."""


@dataclass(frozen=True)
class ComposedFile:
    """A graph file as the sub-graph of a running graph.

    stages: its instances; edges: into them, as stage and port of the sender, stage and port of the receiver,
    and delay; checked_edges: the same edges with their types; outputs: of each output, SUBGRAPH.NAME, the
    ports inside that give it; subgraphs: the file and those below it.
    """

    stages: tuple[CheckedStage, ...]
    edges: frozenset[tuple[str, str, str, str, int]]
    outputs: Mapping[str, tuple[str, ...]]
    checked_edges: tuple[CheckedEdge, ...]
    subgraphs: tuple[SubgraphUse, ...]


def composed_in(plan: Plan, use: SubgraphUse, file: Node, mistakes: list[Mistake]) -> ComposedFile | None:
    """The file in the place of a use in a plan; None if mistakes leave its stages unknown.

    file: its path. What the graph gives the use has the values that the stages have now.
    """
    place, document = file.place, room_document(plan)
    around = _around(plan, use, place)
    entries = {name: node_of({"each": one.each.text}, place) for name, one in around.items() if one.each}
    given, changed = _given(plan, use, place), _changed(plan, use, place)
    found = in_place(file, use, given, changed, entries, plan.room, document, mistakes)
    if found is None:
        return None
    declared = {name: read_stage(name, node, mistakes) for name, node in found.stages.items()}
    old = {stage.name: stage for stage in plan.stages if use.holds(stage.group)}
    loaded = LoadedGraph(
        plan.graph,
        plan.room,
        _with_sources(document, declared, old, place),
        plan.seed,
        {**around, **declared},
        left_out={**_absent(use, declared, around), **found.left_out},
        optional=found.optional,
    )
    expanded = expand(loaded, mistakes)
    inside = {name: one for name, one in expanded.instances.items() if use.holds(one.declared.name)}
    own = tuned_graph(replace(expanded, instances=inside), mistakes)
    check_interface(found.interface_targets, own, mistakes)
    return _checked(plan, expanded, own, found, old, mistakes)


def room_document(plan: Plan) -> Node:
    """The document of the room; only its tunes if the plan came from elsewhere, without it."""
    if plan.room_document is not None:
        return plan.room_document
    return node_of({"tune": dict(plan.room.tune)}, Place("tune of the room", 1, 1))


def _checked(
    plan: Plan,
    expanded: ExpandedGraph,
    own: ExpandedGraph,
    found: InPlace,
    old: Mapping[str, PlannedStage],
    mistakes: list[Mistake],
) -> ComposedFile:
    """The instances with their parameters, and the edges into them. own: those of the file, tuned."""
    classes = {}
    for instance in expanded.instances.values():
        stage = _class(instance, mistakes)
        if stage is not None:
            classes[instance.name] = stage
    stages = []
    for instance in own.instances.values():
        if instance.name in classes:
            stage = classes[instance.name]
            check_inputs(instance, stage, expanded.left_out, mistakes)
            params = _params(instance, stage, old.get(instance.name), mistakes)
            stages += [] if params is None else [CheckedStage(instance, stage, params)]
    checked_edges = tuple(connect(expanded.wires, classes, mistakes))
    edges = {
        (edge.wire.source.name, edge.output, edge.wire.target.name, edge.wire.port, edge.wire.feed.delay)
        for edge in checked_edges
    }
    outputs = subgraph_ports(found.outputs, stages, plan.room)
    return ComposedFile(tuple(stages), frozenset(edges), outputs, checked_edges, found.subgraphs)


def _class(instance: Instance, mistakes: list[Mistake]) -> type[Stage] | None:
    try:
        return load_stage(instance.uses) if instance.uses else None
    except PluginError as error:
        mistakes.append(Mistake(instance.uses_place, error.problem, error.remedy))
        return None


def _params(
    instance: Instance, stage: type[Stage], old: PlannedStage | None, mistakes: list[Mistake]
) -> dict[str, Any] | None:
    """The parameters of an instance; values of `--set` or of a change stay, and so do those of sources."""
    given: dict[str, Any] = {}
    nodes = dict(instance.params)
    if old is not None:
        given = {name: old.params[name] for name in old.kept if name in stage.Params.model_fields}
        if instance.declared.uses == ROOM_SOURCE:
            given, nodes = dict(old.params), dict(instance.declared.params)
    written = {name: node for name, node in nodes.items() if old is None or name not in old.kept}
    noun = f'stage "{instance.declared.name}" ({instance.uses})'
    return validated(stage, noun, written, instance.uses_place, mistakes, given=given)


def _around(plan: Plan, use: SubgraphUse, place: Place) -> dict[str, StageDeclaration]:
    """The stages outside the use, without their inputs, as far as edges from them need it."""
    groups: dict[str, list[PlannedStage]] = {}
    for stage in plan.stages:
        if not use.holds(stage.group):
            groups.setdefault(stage.group, []).append(stage)
    return {name: _declaration(plan, name, stages, place) for name, stages in groups.items()}


def _declaration(plan: Plan, name: str, stages: list[PlannedStage], place: Place) -> StageDeclaration:
    """A declaration with the plugin stage and the members of these instances."""
    first, *_ = stages
    members = tuple(stage.member.name for stage in stages if stage.member is not None)
    each = None if first.member is None else _selector(first.member.set, members, place)
    around = [member for other in plan.subgraphs if other.holds(name) for member in other.members]
    serves = tuple(
        _selector(member.set, (member.name,), place)
        for member in dict.fromkeys(around)
        if first.member is None or first.member.set != member.set
    )
    entry = read_stage(name, node_of({"uses": first.uses}, place), [])
    return replace(entry, each=each, serves=serves)


def _selector(wanted: str, names: tuple[str, ...], place: Place) -> Selector:
    return Selector(wanted, (Condition("name", names),), place)


def _given(plan: Plan, use: SubgraphUse, place: Place) -> dict[str, Node]:
    """The parameters that the graph gives the use, with the values that the stages have now."""
    found: dict[str, Node] = {}
    for name, by_set in use.given.items():
        at = place if by_set else replace(place, file=GIVEN)
        holders = _holders(plan, use, name)
        if holders:
            _, value = min(holders, key=lambda holder: holder[0])
            found[name] = node_of(value, at)
    return found


def _changed(plan: Plan, use: SubgraphUse, place: Place) -> dict[str, Node]:
    """The parameters of the use that a change gave: all stages behind one keep the same value."""
    found: dict[str, Node] = {}
    for name in use.params:
        holders = _holders(plan, use, name)
        if holders and all(is_kept and value == holders[0][1] for is_kept, value in holders):
            found[name] = replace(node_of(holders[0][1], replace(place, file=WHILE_IT_RAN)), key=place)
    return found


def _holders(plan: Plan, use: SubgraphUse, name: str) -> list[tuple[bool, Any]]:
    """The value of a parameter of the interface in each instance that has it, and whether it is kept."""
    leaves = [leaf.rpartition(".")[::2] for leaf in use.params.get(name, ())]
    return [
        (parameter in stage.kept, stage.params[parameter])
        for group, parameter in leaves
        for stage in plan.stages
        if stage.group == group and parameter in stage.params
    ]


def _with_sources(
    document: Node, declared: Mapping[str, StageDeclaration], old: Mapping[str, PlannedStage], place: Place
) -> Node:
    """The document of the room with the sources that the stages of the old file have."""
    sources: dict[str, dict[str, Any]] = {}
    for stage in old.values():
        entry = declared.get(stage.group)
        if entry is not None and entry.uses == ROOM_SOURCE and stage.member is not None:
            source = {"source": {"uses": stage.uses}}
            sources.setdefault(stage.member.set, {})[stage.member.name] = source
    value = document.value if isinstance(document.value, Mapping) else {}
    given = {name: node_of(members, place) for name, members in sources.items()}
    return replace(document, value={**value, **given})


def _absent(
    use: SubgraphUse, declared: Mapping[str, StageDeclaration], around: Mapping[str, StageDeclaration]
) -> dict[str, Mistake]:
    """The senders outside that were left out when the graph began, each with the reason."""
    feeds = (feed for stage in declared.values() for entry in stage.inputs for feed in entry.feeds)
    return {
        feed.stage: Mistake(feed.place, f'stage "{feed.stage}" is left out')
        for feed in feeds
        if feed.stage not in around and not use.holds(feed.stage)
    }
