"""The origin of each parameter that differs from its default: the graph, the room, or `--set`."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator

from followspot.errors import shown
from followspot.graph.check import CheckedGraph
from followspot.graph.instances import CheckedStage, Instance
from followspot.graph.override import WHILE_IT_RAN, is_set, options
from followspot.graph.parameters import plain_default
from followspot.graph.provenance import ParameterOrigin
from followspot.yaml.node import Node

_Row = tuple[str, str, str]
"""A parameter, its value, and the origin of the value."""


def given_text(checked: CheckedGraph) -> str:
    """A line for each parameter that differs from its default, instances that agree together."""
    groups: dict[str, list[CheckedStage]] = defaultdict(list)
    for stage in checked.stages:
        groups[stage.instance.declared.name].append(stage)
    rows = [row for name, stages in groups.items() for row in _rows(name, stages)]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(2)]
    lines = [f"{name:<{widths[0]}}  {value:<{widths[1]}}  {origin}" for name, value, origin in rows]
    return "".join(f"{shown(line)}\n" for line in lines or ["every parameter has its default"])


def _rows(group: str, stages: list[CheckedStage]) -> Iterator[_Row]:
    """The rows of the instances of one stage."""
    instances: dict[_Row, list[str]] = defaultdict(list)
    for stage in stages:
        for row in _given(stage):
            instances[row].append(stage.instance.name)
    for (parameter, value, origin), names in instances.items():
        for name in [group] if len(names) == len(stages) else names:
            yield f"{name}.{parameter}", value, origin


def origins(checked: CheckedGraph) -> dict[str, dict[str, ParameterOrigin]]:
    """The origin of each parameter that is written anywhere, by instance and parameter."""
    return {
        stage.instance.name: {
            parameter: ParameterOrigin(origin_of(node, tuned=parameter in stage.instance.tuned), is_set(node))
            for parameter, node in stage.instance.params.items()
        }
        for stage in checked.stages
    }


def kept_parameters(instance: Instance) -> tuple[str, ...]:
    """The parameters that `--set` gives an instance by the name of its stage, not by that of a sub-graph, and
    those that a change gave.
    """
    own = f"{instance.declared.name}."
    return tuple(
        parameter
        for parameter, node in instance.params.items()
        if node.place.file == WHILE_IT_RAN or any(option.startswith(own) for option in options(node))
    )


def _given(checked: CheckedStage) -> Iterator[_Row]:
    """The parameters of one instance that differ from their defaults."""
    instance = checked.instance
    for parameter, node in instance.params.items():
        required = checked.stage.Params.model_fields[parameter].is_required()
        default = "required" if required else json.dumps(plain_default(checked.stage, parameter))
        value = json.dumps(checked.params[parameter])
        if value != default:
            about = default if required else f"default {default}"
            yield parameter, f"{value} ({about})", origin_of(node, tuned=parameter in instance.tuned)


def origin_of(node: Node, *, tuned: bool) -> str:
    """The place of a value as text, and whether the room tunes it."""
    if is_set(node):
        return "--set"
    places = [f"{found.file}:{found.line}" for found in (node.place, *node.place.outer_places)]
    return " < ".join(dict.fromkeys(places)) + (" (tune of the room)" if tuned else "")
