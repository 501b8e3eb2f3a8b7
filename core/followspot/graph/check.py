"""Third step: check that stages exist, parameters are valid and inputs get messages of their types."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from followspot.errors import Mistake, Place
from followspot.graph.camera_kind import gives_picture
from followspot.graph.checks.fast_loops import joins_in_fast_loops
from followspot.graph.checks.files import check_files
from followspot.graph.checks.flow import Flow
from followspot.graph.checks.inputs import check_inputs
from followspot.graph.checks.left_out import unserved_wires
from followspot.graph.checks.outputs import check_outputs
from followspot.graph.checks.reproducibility import risks
from followspot.graph.checks.warnings import warnings
from followspot.graph.connections import CheckedEdge, check_cycles, check_lagged_cycles, check_types, connect
from followspot.graph.distinct_mistakes import distinct_mistakes
from followspot.graph.expand import ExpandedGraph
from followspot.graph.instances import CheckedStage, Instance
from followspot.graph.parameters import validated
from followspot.graph.sampling import sampled_cycles
from followspot.graph.subgraph_ports import subgraph_ports
from followspot.graph.subgraph_use import SubgraphUse
from followspot.plugins.loaded_hooks import load_scorers
from followspot.plugins.registry import PluginError, load_stage
from followspot.ports.signature import ports
from followspot.room import Room, StageUse
from followspot.stage import Stage
from followspot.yaml.node import Node, child


@dataclass(frozen=True)
class CheckedGraph:
    """A graph without mistakes; nothing is placed yet."""

    name: str
    room: Room
    seed: int
    stages: tuple[CheckedStage, ...]
    edges: tuple[CheckedEdge, ...]
    notes: tuple[str, ...] = ()
    """Notes on stages that are left out, tunes that match nothing, and edges allowed in live runs only."""
    risks: tuple[Mistake, ...] = ()
    """Everything that can make two runs differ."""
    warnings: tuple[Mistake, ...] = ()
    """Everything that can never give a result."""
    offered: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """The outputs of sub-graphs, SUBGRAPH.NAME, with the ports behind each."""
    room_document: Node | None = None
    subgraphs: tuple[SubgraphUse, ...] = ()


def check(expanded: ExpandedGraph, mistakes: list[Mistake]) -> CheckedGraph:
    """Note every mistake; the result is complete only if none was noted."""
    classes = _classes(expanded, mistakes)
    fitting = {}
    for name, stage in classes.items():
        instance = expanded.instances[name]
        check_inputs(instance, stage, expanded.left_out, mistakes)
        if gives_picture(instance, stage, expanded.room, mistakes):
            fitting[name] = stage
    _check_unserved(expanded, classes, mistakes)
    stages = _stages(expanded, classes, mistakes)
    edges = connect(expanded.wires, fitting, mistakes)
    check_cycles(edges, mistakes)
    check_lagged_cycles(edges, classes, mistakes)
    notes = _check_sampled_cycles(expanded, classes, edges, mistakes)
    check_outputs(stages, mistakes)
    doubts = check_files(stages, expanded.room, mistakes)
    room = _checked_room(expanded, mistakes)
    flow = Flow({checked.instance.name: checked for checked in stages}, edges)
    if not mistakes:
        mistakes += distinct_mistakes(joins_in_fast_loops(flow, expanded.room))
    return CheckedGraph(
        name=expanded.name,
        room=room,
        seed=expanded.seed,
        stages=tuple(stages),
        edges=tuple(edges),
        notes=(*expanded.notes, *notes),
        risks=tuple(risks(stages, edges)),
        warnings=() if mistakes else (*distinct_mistakes(doubts), *warnings(flow, expanded)),
        offered=subgraph_ports(expanded.outputs, stages, expanded.room),
        room_document=expanded.room_node,
        subgraphs=expanded.subgraphs,
    )


def _check_sampled_cycles(
    expanded: ExpandedGraph,
    classes: Mapping[str, type[Stage]],
    edges: Sequence[CheckedEdge],
    mistakes: list[Mistake],
) -> list[str]:
    """Note sampled cycles as mistakes of a replay; of a live graph they are the notes that are returned."""
    sampled = sampled_cycles(edge.flow_edge for edge in edges)
    if any(stage.live for stage in classes.values()):
        return [f"{mistake.place}: {mistake.text}; {mistake.remedy}" for mistake in sampled]
    if len(classes) == len(expanded.instances):  # else one that is not known may be live
        mistakes += sampled
    return []


def _check_unserved(
    expanded: ExpandedGraph, classes: Mapping[str, type[Stage]], mistakes: list[Mistake]
) -> None:
    """Note mistakes of stages that are left out, which do not depend on the room."""
    absent: dict[str, type[Stage]] = {}
    for instance in expanded.unserved:
        stage = _class(instance.uses, instance.uses_place, mistakes) if instance.uses else None
        if stage is not None:
            absent[instance.name] = stage
            check_inputs(instance, stage, {}, mistakes)
            _params(instance, stage, mistakes)
    check_types(unserved_wires(expanded), {**classes, **absent}, mistakes)


def _classes(expanded: ExpandedGraph, mistakes: list[Mistake]) -> dict[str, type[Stage]]:
    """The class of each instance whose plugin is well."""
    found = {}
    for instance in expanded.instances.values():
        stage = _class(instance.uses, instance.uses_place, mistakes) if instance.uses else None
        if stage is not None:
            found[instance.name] = stage
    return found


def _stages(
    expanded: ExpandedGraph, classes: Mapping[str, type[Stage]], mistakes: list[Mistake]
) -> list[CheckedStage]:
    """The instances whose parameters are valid."""
    found = []
    for name, stage in classes.items():
        instance = expanded.instances[name]
        params = _params(instance, stage, mistakes)
        if params is not None:
            found.append(CheckedStage(instance, stage, params))
    return found


def _class(uses: str, place: Place, mistakes: list[Mistake]) -> type[Stage] | None:
    try:
        return load_stage(uses)
    except PluginError as error:
        mistakes.append(Mistake(place, error.problem, error.remedy))
        return None


def _params(instance: Instance, stage: type[Stage], mistakes: list[Mistake]) -> dict[str, Any] | None:
    noun = f'stage "{instance.declared.name}" ({instance.uses})'
    return validated(stage, noun, instance.params, instance.uses_place, mistakes)


def _checked_room(expanded: ExpandedGraph, mistakes: list[Mistake]) -> Room:
    """The room, whose truth has validated parameters with absolute paths."""
    truth = expanded.room.truth
    node = child(expanded.room_node, "truth")
    uses = child(node, "uses")
    if truth is None or uses is None:
        return expanded.room
    stage = _class(truth.uses, uses.place, mistakes)
    if stage is None:
        return expanded.room
    found = ports(stage)
    known = tuple(scorer.load().truth for scorer in load_scorers())
    given = [output.type for output in found.outputs]
    if not found.source or len(given) != 1 or not issubclass(given[0], known):
        names = " or ".join(kind.__name__ for kind in known)
        text = f"the truth of a room is a source of {names}, and {truth.uses} is none"
        mistakes.append(Mistake(uses.place, text, "for example cameras.truth_csv"))
        return expanded.room
    params = child(node, "with")
    written = params.value if params is not None and isinstance(params.value, Mapping) else {}
    values = validated(stage, f"the truth ({truth.uses})", written, uses.place, mistakes)
    return replace(expanded.room, truth=StageUse(truth.uses, values or {}, truth.folder))
