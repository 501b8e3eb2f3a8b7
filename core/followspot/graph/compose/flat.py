"""A composed graph as the text of one file without sub-graphs and overlays."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from followspot.graph.compose.compose import ComposedGraph
from followspot.graph.compose.feeds import items, sender
from followspot.graph.declaration import ROOM_SOURCE
from followspot.graph.names import enclosing
from followspot.graph.parameters import path_parameters
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.stage_params import PathIn
from followspot.yaml.node import Node, dump, plain


def flat_text(composed: ComposedGraph, plan: Plan, room: str | None) -> str:
    """The text of a graph file that gives the same plan, wherever it stands: its paths are absolute.

    plan: of this graph; room: path of a room file in place of the graph's own.
    """
    data: dict[str, Any] = {"graph": composed.name}
    if room is not None:
        data["room"] = str(Path(room).absolute())
    elif composed.room is not None:
        data["room"] = _absolute(composed.room.place.file, str(composed.room.value))
    data["seed"] = plan.seed
    stages = _present(composed, {stage.group for stage in plan.stages})
    return dump({**data, "stages": {name: _entry(name, node, plan) for name, node in stages.items()}})


def _present(composed: ComposedGraph, planned: Collection[str]) -> dict[str, Node]:
    """The stages without those that are left out with a sub-graph, and without feeds from them.

    planned: the stages that are in the plan. Optional stages that the room has nothing for stay.
    """
    gone = {*composed.left_out}
    for use in composed.optional:
        inside = {name for name in composed.stages if use.name in enclosing(name)}
        gone |= {use.name, *inside} if inside.isdisjoint(planned) else set()
    unplanned = [name for name in composed.stages if name not in planned]
    before = -1
    while len(gone) > before:
        before = len(gone)
        gone.update(name for name in unplanned if _fed(composed.stages[name], gone))
    return {name: _without(node, gone) for name, node in composed.stages.items() if name not in gone}


def _fed(node: Node, senders: Collection[str]) -> bool:
    """Whether one of these stages feeds a stage."""
    return any(_from(feed) in senders for entry in _inputs(node).values() for feed in items(entry))


def _without(node: Node, gone: Collection[str]) -> Node:
    """The entry of a stage without feeds from these, and without inputs that nothing else feeds."""
    if not (isinstance(node.value, Mapping) and _fed(node, gone)):
        return node
    fed = {
        port: replace(entry, value=kept)
        for port, entry in _inputs(node).items()
        if (kept := tuple(feed for feed in items(entry) if _from(feed) not in gone))
    }
    return replace(node, value={**node.value, "in": replace(node.value["in"], value=fed)})


def _inputs(node: Node) -> Mapping[str, Node]:
    inputs = node.value.get("in") if isinstance(node.value, Mapping) else None
    return inputs.value if inputs is not None and isinstance(inputs.value, Mapping) else {}


def _from(feed: Node) -> str:
    """The stage that a feed comes from."""
    return (sender(feed) or ("",))[0]


def _entry(name: str, node: Node, plan: Plan) -> Any:
    """The entry of a stage with absolute input paths."""
    entry = plain(node)
    params = node.value.get("with") if isinstance(node.value, Mapping) else None
    if params is not None and isinstance(params.value, Mapping):
        for key in _input_paths(entry["uses"], plan) & params.value.keys():
            value = params.value[key]
            if isinstance(value.value, str):
                entry["with"][key] = _absolute(value.place.file, value.value)
    return entry


def _input_paths(uses: str, plan: Plan) -> set[str]:
    """Names of parameters that are input paths of the stage, or of any source for which it stands."""
    sources = {carrier.source.uses for carrier in plan.room.carriers if carrier.source}
    used = sources if uses == ROOM_SOURCE else {uses}
    return {name for found in used for name in path_parameters(load_stage(found).Params, PathIn)}


def _absolute(file: str, path: str) -> str:
    """A path that is relative to the file in which it stands."""
    return str((Path(file).parent / path).absolute())
