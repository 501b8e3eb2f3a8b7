"""`hall=other.yaml`: a graph file takes the place of another while the graph runs.

Stages and edges of a running graph stay, so the new file must have the stages and edges of the old one; what
differs is which plugin stages they are, and their parameters. The new file is composed where the old one
stood, with what the graph feeds it and gives it; no other file of the graph is read again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from followspot.document import Node
from followspot.errors import InputError, Mistake, Place
from followspot.graph.given import origin_of
from followspot.graph.override import is_set
from followspot.graph.plan import Origin, Plan, PlannedStage
from followspot.graph.subgraph_plan import GIVEN, Composed, composed_in
from followspot.graph.subgraph_use import SubgraphUse

_RESTART = "a running graph keeps its stages and edges: stop it, and run it with --set {name}.graph=FILE"
BY_A_CHANGE = Origin("while it ran", kept=True)
_Edge = tuple[str, str, str, str, int]


@dataclass(frozen=True)
class StageChange:
    """What an instance becomes: the plugin stage and the parameters that differ."""

    name: str
    uses: str
    params: Mapping[str, Any]
    origins: Mapping[str, Origin]


def uses_of(plan: Plan, name: str) -> list[SubgraphUse]:
    """The uses of files that a name stands for: one, or those of all members; none if it is no sub-graph."""
    return [use for use in plan.subgraphs if name in use.names]


def replaced(plan: Plan, use: SubgraphUse, file: Node) -> tuple[list[StageChange], tuple[SubgraphUse, ...]]:
    """The stages that change with another file in the place of a use, and the sub-graphs of the plan then.

    file: its path. Raises InputError with every mistake.
    """
    mistakes: list[Mistake] = []
    found = composed_in(plan, use, file, mistakes)
    if mistakes or found is None:
        raise InputError(mistakes)
    _check_same(plan, use, found, file.place)
    kept = [other for other in plan.subgraphs if other != use and not use.holds(other.name)]
    return _differing(plan, use, found), (*kept, *found.subgraphs)


def _inside(plan: Plan, use: SubgraphUse) -> dict[str, PlannedStage]:
    return {stage.name: stage for stage in plan.stages if use.holds(stage.group)}


def _differing(plan: Plan, use: SubgraphUse, found: Composed) -> list[StageChange]:
    """The stages that are another plugin stage or have other parameters."""
    old = _inside(plan, use)
    changes = []
    for stage in found.stages:
        name, was = stage.instance.name, old[stage.instance.name]
        same = stage.instance.uses == was.uses
        params = {k: v for k, v in stage.params.items() if not (same and was.params.get(k) == v)}
        if params or not same:
            before = plan.origins.get(name, {})
            origins = {
                parameter: _origin(node, use, tuned=parameter in stage.instance.tuned)
                for parameter, node in stage.instance.params.items()
            }
            origins |= {k: before.get(k, BY_A_CHANGE) for k in was.kept if k in stage.params}
            changes.append(StageChange(name, stage.instance.uses, params, origins))
    return changes


def _origin(node: Node, use: SubgraphUse, *, tuned: bool) -> Origin:
    """What gives a parameter its value: the new file, the room, or the graph that uses the file."""
    passed = node.place.file == GIVEN
    return Origin(use.name if passed else origin_of(node, tuned=tuned), is_set(node))


def _check_same(plan: Plan, use: SubgraphUse, found: Composed, place: Place) -> None:
    """Raises InputError if the file has other stages, edges or policies in the place of the old one."""
    old, new = _inside(plan, use), {stage.instance.name: stage.instance for stage in found.stages}
    gone, added = sorted(old.keys() - new.keys()), sorted(new.keys() - old.keys())
    if gone or added:
        said = [f"lacks {', '.join(gone[:4])}"] if gone else []
        said += [f"adds {', '.join(added[:4])}"] if added else []
        _refuse(f'the file {" and ".join(said)} in sub-graph "{use.name}"', use, place)
    edges = _edges(plan, old) ^ found.edges
    if edges:
        start, port, end, to, _ = min(edges)
        _refuse(f'the file connects "{start}.{port}" and "{end}.{to}" in another way', use, place)
    _check_outputs(plan, use, found, place)
    for instance in new.values():
        declared, was = instance.declared, old[instance.name]
        policy = (declared.on_error, declared.tolerance, declared.deadline)
        if policy != (was.on_error, was.tolerance, was.deadline):
            text = f'on_error, tolerance or deadline of "{instance.name}" differ in the file'
            _refuse(text, use, place)


def _check_outputs(plan: Plan, use: SubgraphUse, found: Composed, place: Place) -> None:
    """Raises InputError if an output that is read is missing, or another port than before."""
    leaving = {f"{edge.from_stage}.{edge.from_port}" for edge in plan.edges if not use.holds(edge.to_stage)}
    for name, before in plan.offered.items():
        subgraph, _, port = name.partition(".")
        if not (subgraph == use.name or use.holds(subgraph)):
            continue
        after = found.outputs.get(name)
        if after is None and leaving & set(before):
            _refuse(f'sub-graph "{subgraph}" has no output "{port}" in the file', use, place)
        if after is not None and after != before:
            text = f'the output "{name}" is {", ".join(after)} in the file, and was {", ".join(before)}'
            _refuse(text, use, place)


def _edges(plan: Plan, inside: Mapping[str, PlannedStage]) -> set[_Edge]:
    """The edges into the stages of a sub-graph."""
    return {
        (edge.from_stage, edge.from_port, edge.to_stage, edge.to_port, edge.delay)
        for edge in plan.edges
        if edge.to_stage in inside
    }


def _refuse(text: str, use: SubgraphUse, place: Place) -> None:
    raise InputError([Mistake(place, text, _RESTART.format(name=use.stage))])
