"""`hall=other.yaml`: a graph file takes the place of another while the graph runs.

The new file is composed where the old one stood, with what the graph feeds it and gives it; no other file of
the graph is read again. If it has the stages and edges of the old one, only plugin stages and parameters
change; else stages and edges come and go.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from followspot.errors import InputError, Mistake
from followspot.graph.change.rewiring import plan_with_file
from followspot.graph.change.subgraph_plan import GIVEN, ComposedFile, composed_in
from followspot.graph.instances import CheckedStage
from followspot.graph.override import WHILE_IT_RAN, is_set
from followspot.graph.parameter_origin import origin_of
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.provenance import ParameterOrigin
from followspot.graph.subgraph_use import SubgraphUse
from followspot.yaml.node import Node

BY_A_CHANGE = ParameterOrigin("while it ran", kept=True)
_Edge = tuple[str, str, str, str, int]


@dataclass(frozen=True)
class StageChange:
    """The change of one instance: the plugin stage and the parameters that differ."""

    name: str
    uses: str
    params: Mapping[str, Any]
    origins: Mapping[str, ParameterOrigin]


def uses_of(plan: Plan, name: str) -> list[SubgraphUse]:
    """The uses of files that a name stands for: one, or those of all members; none if it is no sub-graph."""
    return [use for use in plan.subgraphs if name in use.names]


@dataclass(frozen=True)
class SubgraphReplacement:
    """A plan in which another file is in the place of a sub-graph.

    changes: the stages that change, if the file has the stages and edges of the old one; None if it has
    others: then all is in the plan already.
    """

    plan: Plan
    changes: list[StageChange] | None


def with_subgraph_replaced(plan: Plan, use: SubgraphUse, file: Node) -> SubgraphReplacement:
    """The plan with another file in the place of a use.

    file: its path. Raises InputError with every mistake.
    """
    mistakes: list[Mistake] = []
    found = composed_in(plan, use, file, mistakes)
    if mistakes or found is None:
        raise InputError(mistakes)
    kept = [
        _passing_on(other, use, found)
        for other in plan.subgraphs
        if other != use and not use.holds(other.name)
    ]
    after = replace(plan, subgraphs=(*kept, *found.subgraphs))
    if _is_alike(plan, use, found):
        return SubgraphReplacement(after, _differing(plan, use, found))
    new = plan_with_file(after, use, found, file.place)
    origins = {name: dict(known) for name, known in plan.origins.items() if name not in _inside(plan, use)}
    origins |= {stage.instance.name: _origins(plan, use, stage) for stage in found.stages}
    return SubgraphReplacement(replace(new, origins=origins), None)


def _passing_on(outer: SubgraphUse, use: SubgraphUse, found: ComposedFile) -> SubgraphUse:
    """A use of a file whose parameters also set those of the new file, if the replaced use is inside it."""
    new = next((one for one in found.subgraphs if one.name == use.name), None)
    if new is None or not outer.holds(use.name):
        return outer
    leaves = {old: new.params.get(name, ()) for name, before in use.params.items() for old in before}
    passed = {
        name: tuple(dict.fromkeys(leaf for old in before for leaf in leaves.get(old, (old,))))
        for name, before in outer.params.items()
    }
    return replace(outer, params={name: found for name, found in passed.items() if found})


def _inside(plan: Plan, use: SubgraphUse) -> dict[str, PlannedStage]:
    return {stage.name: stage for stage in plan.stages if use.holds(stage.group)}


def _differing(plan: Plan, use: SubgraphUse, found: ComposedFile) -> list[StageChange]:
    """The stages that are another plugin stage or have other parameters."""
    old = _inside(plan, use)
    changes = []
    for stage in found.stages:
        name, was = stage.instance.name, old[stage.instance.name]
        same = stage.instance.uses == was.uses
        params = {k: v for k, v in stage.params.items() if not (same and was.params.get(k) == v)}
        if params or not same:
            changes.append(StageChange(name, stage.instance.uses, params, _origins(plan, use, stage)))
    return changes


def _origins(plan: Plan, use: SubgraphUse, stage: CheckedStage) -> dict[str, ParameterOrigin]:
    """The origins of the parameters of a stage of the file."""
    name = stage.instance.name
    was = next((old for old in plan.stages if old.name == name), None)
    before = plan.origins.get(name, {})
    origins = {
        parameter: _origin(node, use, tuned=parameter in stage.instance.tuned)
        for parameter, node in stage.instance.params.items()
    }
    kept = () if was is None else was.kept
    return origins | {k: before.get(k, BY_A_CHANGE) for k in kept if k in stage.params}


def _origin(node: Node, use: SubgraphUse, *, tuned: bool) -> ParameterOrigin:
    """The origin of a parameter's value: the new file, the room, or the graph that uses the file."""
    if node.place.file == WHILE_IT_RAN:
        return BY_A_CHANGE
    passed = node.place.file == GIVEN
    return ParameterOrigin(use.name if passed else origin_of(node, tuned=tuned), is_set(node))


def _is_alike(plan: Plan, use: SubgraphUse, found: ComposedFile) -> bool:
    """True if the file has the stages, edges, outputs and policies of the old one."""
    old, new = _inside(plan, use), {stage.instance.name: stage for stage in found.stages}
    if old.keys() != new.keys() or _edges(plan, old) != found.edges:
        return False
    for name, before in plan.offered.items():
        subgraph = name.partition(".")[0]
        if (subgraph == use.name or use.holds(subgraph)) and found.outputs.get(name, before) != before:
            return False
    return _has_read_outputs(plan, use, found) and all(
        (one.instance.declared.on_error, one.tolerance, one.instance.declared.deadline)
        == (old[name].on_error, old[name].tolerance, old[name].deadline)
        for name, one in new.items()
    )


def _has_read_outputs(plan: Plan, use: SubgraphUse, found: ComposedFile) -> bool:
    """True if the file offers all outputs that something outside reads."""
    read = {f"{edge.from_stage}.{edge.from_port}" for edge in plan.edges if not use.holds(edge.to_stage)}
    own = {n: p for n, p in plan.offered.items() if n.partition(".")[0] == use.name and read & set(p)}
    return own.keys() <= found.outputs.keys()


def _edges(plan: Plan, inside: Mapping[str, PlannedStage]) -> set[_Edge]:
    """The edges into the stages of a sub-graph."""
    return {
        (edge.from_stage, edge.from_port, edge.to_stage, edge.to_port, edge.delay)
        for edge in plan.edges
        if edge.to_stage in inside
    }
