"""`hall=other.yaml`, `hall.similarity=0.7`: a sub-graph of a running plan changes as a whole.

The graph is planned anew with the change. Stages and edges of a running graph stay, so the new file must have
the stages and edges of the old one; what differs is which plugin stages they are, and their parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from followspot.errors import InputError, Mistake, Place
from followspot.graph.compile import compile_graph
from followspot.graph.names import enclosing
from followspot.graph.override import SUBGRAPH
from followspot.graph.plan import Origin, Plan, PlannedStage, Recipe

_RESTART = "a running graph keeps its stages and edges: stop it, and run it with --set {name}.graph=FILE"
BY_A_CHANGE = Origin("while it ran", kept=True)
_Edge = tuple[str, str, str, str, int]


@dataclass(frozen=True)
class StageChange:
    """What an instance becomes: the plugin stage, "" for that which it is, and the parameters that differ."""

    name: str
    uses: str
    params: Mapping[str, Any]
    origins: Mapping[str, Origin]


def is_subgraph(plan: Plan, name: str) -> bool:
    """True if stages of the plan are below this name."""
    return any(name in enclosing(stage.group)[:-1] for stage in plan.stages)


def subgraph_changes(plan: Plan, word: str, folder: Path, place: Place) -> tuple[list[StageChange], Recipe]:
    """What the word changes, and how the plan is made with it. Raises InputError with every mistake.

    word: SUBGRAPH=FILE or SUBGRAPH.PARAMETER=VALUE; folder: that the path is relative to; place: of the word.
    """
    if plan.recipe is None:
        text = "this run does not know the graph file that it was made from"
        raise InputError([Mistake(place, text, "change its stages one by one")])
    path, _, value = word.partition("=")
    name, _, key = path.partition(".")
    if key:
        _check_key(key.partition(".")[0], name, place)
        fresh = _planned(plan.recipe, plan, word)
        _check_same(plan, fresh, name, place)
        return _set(fresh, name, word), plan.recipe
    made = (*plan.recipe.overrides, f"{path}.graph={(folder / value).absolute()}")
    recipe = replace(plan.recipe, overrides=made)
    fresh = _planned(recipe, plan)
    _check_same(plan, fresh, name, place)
    return _differing(plan, fresh, name), recipe


def _check_key(key: str, name: str, place: Place) -> None:
    """Raises InputError for a key that parameters do not stand below."""
    if key in SUBGRAPH and key != "with":
        text = f'"{key}" of sub-graph "{name}" cannot be changed'
        remedy = f"write {name}.PARAMETER=VALUE, or swap {name}=FILE"
        raise InputError([Mistake(place, text, remedy)])


def _planned(recipe: Recipe, plan: Plan, *words: str) -> Plan:
    """The plan that the recipe makes, with more overrides; its plugins are loaded."""
    return compile_graph(
        recipe.graph, room=recipe.room, overrides=(*recipe.overrides, *words), seed=plan.seed
    )


def _stages(plan: Plan, name: str) -> dict[str, PlannedStage]:
    return {stage.name: stage for stage in plan.stages if name in enclosing(stage.group)[:-1]}


def _set(fresh: Plan, name: str, word: str) -> list[StageChange]:
    """The parameters that the word gives; each stage stays the plugin stage that it has become in the run."""
    found = []
    for stage in _stages(fresh, name).values():
        origins = fresh.origins.get(stage.name, {})
        params = {key: stage.params[key] for key, origin in origins.items() if word in origin.options}
        if params:
            found.append(StageChange(stage.name, "", params, dict.fromkeys(params, BY_A_CHANGE)))
    return found


def _differing(before: Plan, after: Plan, name: str) -> list[StageChange]:
    """The stages of a sub-graph that are another plugin stage or have other parameters.

    What a change gave before stays if the stage still has the parameter.
    """
    old = _stages(before, name)
    found = []
    for stage in _stages(after, name).values():
        was = old[stage.name]
        same = stage.uses == was.uses
        given = before.origins.get(stage.name, {})
        kept = {k: was.params[k] for k in stage.params if given.get(k) == BY_A_CHANGE}
        wanted = {**stage.params, **kept}
        params = {k: v for k, v in wanted.items() if not (same and was.params.get(k) == v)}
        if params or not same:
            origins = {**after.origins.get(stage.name, {}), **dict.fromkeys(kept, BY_A_CHANGE)}
            found.append(StageChange(stage.name, stage.uses, params, origins))
    return found


def _check_same(plan: Plan, fresh: Plan, name: str, place: Place) -> None:
    """Raises InputError if the sub-graph has other stages, edges or policies in the fresh plan."""
    old, new = _stages(plan, name), _stages(fresh, name)
    gone, added = sorted(old.keys() - new.keys()), sorted(new.keys() - old.keys())
    if gone or added:
        said = [f"lacks {', '.join(gone[:4])}"] if gone else []
        said += [f"adds {', '.join(added[:4])}"] if added else []
        _refuse(f'the file {" and ".join(said)} in sub-graph "{name}"', name, place)
    edges = _edges(plan, old, fresh) ^ _edges(fresh, new, plan)
    if edges:
        start, port, end, to, _ = min(edges)
        _refuse(f'the file connects "{start}.{port}" and "{end}.{to}" in another way', name, place)
    for stage in new.values():
        if _policy(stage) != _policy(old[stage.name]):
            text = f'on_error, tolerance or deadline of "{stage.name}" differ in the file'
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
