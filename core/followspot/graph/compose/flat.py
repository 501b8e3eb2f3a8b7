"""A composed graph as the text of one file without sub-graphs and overlays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from followspot.document import dump, plain
from followspot.graph.compose.compose import Composed
from followspot.graph.expand import ROOM_SOURCE
from followspot.graph.parameters import path_parameters
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.stage_params import PathIn


def flat_text(composed: Composed, plan: Plan, room: str | None) -> str:
    """The text of a graph file that gives the same plan, wherever it stands: its paths are absolute.

    plan: of this graph; room: path of a room file in place of the graph's own.
    """
    data: dict[str, Any] = {"graph": composed.name}
    if room is not None:
        data["room"] = str(Path(room).absolute())
    elif composed.room is not None:
        data["room"] = _absolute(composed.room.place.file, str(composed.room.value))
    data["seed"] = plan.seed
    return dump({**data, "stages": {name: _entry(name, composed, plan) for name in composed.stages}})


def _entry(name: str, composed: Composed, plan: Plan) -> Any:
    """The entry of a stage with absolute input paths."""
    node = composed.stages[name]
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
