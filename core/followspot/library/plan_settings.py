"""The options of a plan, as scripts give them."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypedDict, Unpack, get_args

from followspot.errors import InputError, did_you_mean
from followspot.graph.arrange import EdgeChoice
from followspot.graph.compile import compile_graph
from followspot.graph.override import as_option
from followspot.graph.plan import MAX_SEED, Plan
from followspot.library.graph import Graph
from followspot.library.keywords import errors_in_python, mistakes_in_python
from followspot.plugins.registry import offer_stage

PATH = str | Path


class PlanSettings(TypedDict, total=False):
    """Options of a plan besides the graph and its parameters, as `followspot.run` takes them."""

    room: str | Path | None
    cameras: str | Sequence[str]
    placement: str | Path | None
    seed: int | None
    plugin_files: str | Path | Sequence[str | Path]
    edges: EdgeChoice


def plan_of(
    graph: str | Path | Graph,
    settings: Mapping[str, Any] | None,
    ports: Sequence[str] = (),
    **options: Unpack[PlanSettings],
) -> Plan:
    """The plan of a graph with these options. Raises InputError with every mistake."""
    with errors_in_python():
        plan = _compiled(graph, settings, ports, **options)
    return replace(plan, warnings=mistakes_in_python(plan.warnings))


def _compiled(
    graph: str | Path | Graph,
    settings: Mapping[str, Any] | None,
    ports: Sequence[str],
    **options: Unpack[PlanSettings],
) -> Plan:
    if not isinstance(settings, Mapping | None) or not all(isinstance(name, str) for name in settings or ()):
        raise InputError.of(f"set is {settings!r}", 'give a mapping, for example {"fuse.uses": "balls.mean"}')
    overrides = [_override(name, value) for name, value in (settings or {}).items()]
    _check_files(graph, options)
    remedy = f"give a whole number from 0 to {MAX_SEED}, or nothing for the graph's"
    checked: dict[str, Any] = {
        **options,
        "cameras": as_tuple("cameras", options.get("cameras", ())),
        "plugin_files": as_tuple("plugin_files", options.get("plugin_files", ())),
        "seed": whole_number("seed", options.get("seed"), 0, remedy, MAX_SEED),
    }
    edges = options.get("edges", "auto")
    if edges not in get_args(EdgeChoice):
        raise InputError.of(f"edges is {edges!r}", did_you_mean(str(edges), get_args(EdgeChoice), "edges"))
    if isinstance(graph, Graph):
        return graph.plan(overrides=overrides, subscribed=ports, **checked)
    return compile_graph(graph, overrides=overrides, subscribed=ports, **checked)


def _override(name: str, value: Any) -> str:
    """The `--set` of a parameter, or of a stage, which may be a class of this process."""
    stage = name.endswith(".uses") and isinstance(value, type)
    return as_option(name, offer_stage(value) if stage else value)


def whole_number(name: str, value: Any, least: int, remedy: str, most: int | None = None) -> int | None:
    """An option that is a whole number, of numpy too, or None. Raises InputError."""
    if value is None:
        return None
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least or (most is not None and number > most):
        raise InputError.of(f"{name} is {value!r}", remedy)
    return number


def check_type(name: str, value: Any, kind: Any, remedy: str) -> None:
    """Raise InputError for an option that is empty or of another kind. kind: as `isinstance` takes it."""
    if not isinstance(value, kind):
        raise InputError.of(f"{name} is of type {type(value).__name__}", remedy)
    if value == "":
        raise InputError.of(f"{name} is empty", remedy)


def as_tuple(name: str, values: Any) -> tuple[Any, ...]:
    """Several names or files; one may stand alone. Raises InputError."""
    found = (values,) if isinstance(values, PATH) else values
    if not isinstance(found, Iterable) or not all(isinstance(value, PATH) for value in found):
        raise InputError.of(f"{name} is {values!r:.80}", "give a text, or a list of texts")
    return tuple(found)


def _check_files(graph: Any, options: PlanSettings) -> None:
    """Raise InputError for a file that is named by anything but a path."""
    check_type("graph", graph, PATH | Graph, "give the path of a graph file, or an fs.Graph")
    remedy = "give the path of a room file; followspot.room_file.save(room, path) writes one"
    check_type("room", options.get("room"), PATH | None, remedy)
    remedy = 'give "camera", "stage", or the path of a placement file'
    check_type("placement", options.get("placement"), PATH | None, remedy)
