"""`hall=other.yaml`, `hall.similarity=0.7`: a sub-graph of a running plan changes as a whole.

The graph is planned anew with the change. Stages and edges of a running graph stay, so the new file must have
the stages and edges of the old one; what differs is which plugin stages they are, and their parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from followspot.errors import InputError, Mistake, Place
from followspot.graph.compile import compile_graph
from followspot.graph.names import enclosing
from followspot.graph.plan import Plan, PlannedStage

_RESTART = "a running graph keeps its stages and edges: stop it, and run it with --set {name}.graph=FILE"
_Edge = tuple[str, str, str, str, int]


@dataclass(frozen=True)
class StageChange:
    """What an instance becomes: the plugin stage, and the parameters that differ."""

    name: str
    uses: str
    params: Mapping[str, Any]


def is_subgraph(plan: Plan, name: str) -> bool:
    """True if stages of the plan are below this name."""
    return any(name in enclosing(stage.group)[:-1] for stage in plan.stages)


def subgraph_changes(plan: Plan, word: str, folder: Path, place: Place) -> list[StageChange]:
    """What the word changes. Raises InputError with every mistake.

    word: SUBGRAPH=FILE or SUBGRAPH.PARAMETER=VALUE; folder: that the path is relative to; place: of the word.
    """
    if plan.recipe is None:
        text = "this run does not know the graph file that it was made from"
        raise InputError([Mistake(place, text, "change its stages one by one")])
    path, _, value = word.partition("=")
    name, _, key = path.partition(".")
    fresh = _planned(plan, f"{path}={value}" if key else f"{path}.graph={(folder / value).absolute()}")
    if key:
        return _differing(_planned(plan), fresh, name)
    _check_same(plan, fresh, name, place)
    return _differing(plan, fresh, name)


def _planned(plan: Plan, *words: str) -> Plan:
    """The plan of the graph file with more overrides; its plugins are loaded."""
    made = plan.recipe
    assert made is not None
    return compile_graph(made.graph, room=made.room, overrides=(*made.overrides, *words), seed=plan.seed)


def _stages(plan: Plan, name: str) -> dict[str, PlannedStage]:
    return {stage.name: stage for stage in plan.stages if name in enclosing(stage.group)[:-1]}


def _differing(before: Plan, after: Plan, name: str) -> list[StageChange]:
    """The stages of a sub-graph that are another plugin stage or have other parameters."""
    old = _stages(before, name)
    found = []
    for stage in _stages(after, name).values():
        was = old[stage.name]
        same = stage.uses == was.uses
        params = {k: v for k, v in stage.params.items() if not (same and was.params.get(k) == v)}
        if params or not same:
            found.append(StageChange(stage.name, stage.uses, params))
    return found


def _check_same(plan: Plan, fresh: Plan, name: str, place: Place) -> None:
    """Raises InputError if the sub-graph has other stages, edges or policies in the fresh plan."""
    old, new = _stages(plan, name), _stages(fresh, name)
    gone, added = sorted(old.keys() - new.keys()), sorted(new.keys() - old.keys())
    if gone or added:
        said = [f"lacks {', '.join(gone[:4])}"] if gone else []
        said += [f"adds {', '.join(added[:4])}"] if added else []
        _refuse(f'the new file {" and ".join(said)} in sub-graph "{name}"', name, place)
    edges = _edges(plan, old, fresh) ^ _edges(fresh, new, plan)
    if edges:
        start, port, end, to, _ = min(edges)
        _refuse(f'the new file connects "{start}.{port}" and "{end}.{to}" in another way', name, place)
    for stage in new.values():
        if _policy(stage) != _policy(old[stage.name]):
            text = f'on_error, tolerance or deadline of "{stage.name}" differ in the new file'
            _refuse(text, name, place)


def _edges(plan: Plan, inside: Mapping[str, PlannedStage], other: Plan) -> set[_Edge]:
    """The edges of a sub-graph to stages that both plans have: a recorder may read it, too."""
    known = {stage.name for stage in other.stages}
    return {
        (edge.from_stage, edge.from_port, edge.to_stage, edge.to_port, edge.delay)
        for edge in plan.edges
        if {edge.from_stage, edge.to_stage} & inside.keys() and {edge.from_stage, edge.to_stage} <= known
    }


def _policy(stage: PlannedStage) -> Sequence[object]:
    return (stage.on_error, stage.tolerance, stage.deadline)


def _refuse(text: str, name: str, place: Place) -> None:
    raise InputError([Mistake(place, text, _RESTART.format(name=name))])
