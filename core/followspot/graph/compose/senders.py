"""The senders of an input, through the interfaces of sub-graphs: stages of the flat graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from followspot.errors import Mistake, did_you_mean
from followspot.graph.compose.feeds import (
    items,
    joined,
    option,
    origin,
    renamed,
    seen_with,
    sender,
    with_option,
)
from followspot.graph.compose.narrowing import Limit, both, narrowed
from followspot.graph.compose.unit import Unit
from followspot.graph.names import below, enclosing
from followspot.yaml.node import Node

_Visited = tuple[tuple[str, str, str | None], ...]
"""The senders that led to one: unit, stage and port of each."""


def senders(unit: Unit, feed: Node, mistakes: list[Mistake], visited: _Visited = ()) -> list[Node]:
    """The feed, or those that it stands for, with the full names of stages.

    A malformed feed and one from an unknown stage stay as they are, for a later step to note.
    """
    named = sender(feed)
    if named is None:
        return [feed]
    stage, port = named
    step = (unit.name, stage, port)
    if step in visited:
        mistakes.append(_fed_from_itself(feed, (*visited[visited.index(step) :], step)))
        return []
    visited = (*visited, step)
    if stage in unit.replaced:
        return _of_replaced(unit, stage, port, feed, mistakes, visited)
    absent = next((name for name in enclosing(stage) if name in unit.left_out), None)
    if absent is not None:
        if stage in unit.apart:  # for the mistakes alone: what is left out feeds nothing
            _of_output(unit.apart[stage], port, feed, mistakes, visited)
        return [renamed(feed, _join(below(unit.name, absent), port))]
    if stage in unit.units:
        return [
            one for inner in unit.units[stage] for one in _of_output(inner, port, feed, mistakes, visited)
        ]
    full = below(unit.name, stage)
    around = None if stage in unit.stages else _around(unit, full)
    if around is None:
        return [renamed(feed, _join(full, port))]
    if around.name == full:  # one member of a sub-graph that fans out
        return _of_output(around, port, feed, mistakes, visited)
    text = _join(full.removeprefix(f"{around.name}/"), port)
    return senders(around, renamed(feed, text), mistakes, visited)


def _fed_from_itself(feed: Node, circle: _Visited) -> Mistake:
    """The mistake of a feed that leads back to itself. circle: the senders from the feed back to it."""
    steps = " -> ".join(_join(below(unit, stage), port) for unit, stage, port in circle)
    return Mistake(origin(feed).place, f"this input is fed from itself: {steps}", "feed it from a stage")


def _of_replaced(
    unit: Unit, stage: str, port: str | None, feed: Node, mistakes: list[Mistake], visited: _Visited
) -> list[Node]:
    """The senders that the use of a sub-graph connects in place of one of its stages."""
    wired = unit.replaced[stage]
    outer = [one for item in items(wired.feeds) for one in senders(wired.unit, item, mistakes, visited)]
    found = [joined(_with_port(seen_with(one, feed), port), feed) for one in outer]
    return [_only(one, unit.stages[stage], unit.limits) for one in found]


def _around(unit: Unit, full: str) -> Unit | None:
    """The sub-graph of the unit that has this full name, or a stage of this full name inside."""
    units = (inner for units in unit.units.values() for inner in units)
    return next((inner for inner in units if f"{full}/".startswith(f"{inner.name}/")), None)


def _of_output(
    unit: Unit, port: str | None, feed: Node, mistakes: list[Mistake], visited: _Visited
) -> list[Node]:
    """The senders behind an output of a sub-graph: the named one, else the only one."""
    outputs = unit.interface.outputs
    if "outputs" in unit.file.unreadable:
        return []
    chosen = port if port is not None else next(iter(outputs)) if len(outputs) == 1 else None
    targets = outputs.get(chosen) if chosen is not None else None
    if targets is None:
        place = origin(feed).place.beside(unit.file.place)
        if port is not None:
            text = f'sub-graph "{unit.name}" has no output "{port}"'
            mistakes.append(Mistake(place, text, did_you_mean(port, outputs, "outputs")))
        else:
            text = f'sub-graph "{unit.name}" has {"several outputs" if outputs else "no outputs"}'
            remedy = f"name one: {', '.join(f'{unit.name}.{name}' for name in outputs)}"
            remedy = remedy if outputs else "add to its file: outputs: {NAME: STAGE.PORT}"
            mistakes.append(Mistake(place, text, remedy))
        return []
    found = []
    for target in targets:  # one, or none if a mistake was noted
        inner = seen_with(replace(target.node, place=origin(feed).place), target.node)
        found += [joined(one, feed) for one in senders(unit, inner, mistakes, visited)]
    return found


def _only(feed: Node, replaced: Node, limits: Sequence[Limit]) -> Node:
    """The feed from those members alone that the replaced stage served."""
    each = replaced.value.get("each") if isinstance(replaced.value, Mapping) else None
    selector = None if each is None else narrowed(each, limits)
    if selector is None or "[" not in str(selector.value):
        return feed
    chosen = option(feed, "only")
    return with_option(feed, "only", selector if chosen is None else both(chosen, selector))


def _with_port(feed: Node, port: str | None) -> Node:
    """The feed from a port of its stage, unless it names one already."""
    text = str(origin(feed).value)
    return feed if port is None or "." in text else renamed(feed, f"{text}.{port}")


def _join(stage: str, port: str | None) -> str:
    return stage if port is None else f"{stage}.{port}"
