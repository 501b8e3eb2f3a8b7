"""Applies one use of a sub-graph to its interface: connects its inputs, and gives its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.compose.feeds import items
from followspot.graph.compose.interface import SECTION, InterfaceTarget
from followspot.graph.compose.unit import Unit, WiredInput
from followspot.graph.override import with_value


def apply_use(unit: Unit, mistakes: list[Mistake]) -> None:
    """Connect `unit.inputs` and give `unit.given`, where the interface says; `mistakes` receives mistakes."""
    connected: list[tuple[InterfaceTarget, str]] = []
    for name, wired in unit.inputs.items():
        targets = unit.interface.inputs.get(name)
        if targets is None:
            _unknown(unit, "input", name, wired.feeds.key, unit.interface.inputs, mistakes)
        elif not items(wired.feeds):
            text = f'input "{name}" of sub-graph "{unit.name}" is fed by nothing'
            mistakes.append(Mistake(wired.feeds.place, text, "name a stage"))
        else:
            for target in targets:
                _connect(unit, target, name, wired, connected, mistakes)
    _give_params(unit, mistakes)


def _connect(
    unit: Unit,
    target: InterfaceTarget,
    name: str,
    wired: WiredInput,
    connected: list[tuple[InterfaceTarget, str]],
    mistakes: list[Mistake],
) -> None:
    """Connect an input to one of its targets, unless one of those connected before has taken it."""
    first = next((other for known, other in connected if _overlap(known, target)), None)
    if first is not None:
        text = f'inputs "{first}" and "{name}" of sub-graph "{unit.name}" both feed {target.stage}'
        mistakes.append(_wrong(wired.feeds.key, target, text, "connect one of them"))
    elif target.name is None:
        unit.replaced[target.stage] = wired
    else:
        key = wired.feeds.key.beside(target.node.place)
        unit.wired[target.stage, target.name] = replace(wired, feeds=replace(wired.feeds, key=key))
    connected.append((target, name))


def _give_params(unit: Unit, mistakes: list[Mistake]) -> None:
    """Put the values below `with` where the interface says."""
    by: dict[tuple[str, str | None], str] = {}
    for name, value in unit.given.items():
        targets = unit.interface.params.get(name)
        if targets is None:
            _unknown(unit, "parameter", name, value.key, unit.interface.params, mistakes)
        for target in targets or ():
            key, place = (place.beside(target.node.place) for place in (value.key, value.place))
            keys = ("with", *(target.name or "").split("."))
            first = by.setdefault((target.stage, target.name), name)
            if first != name:
                text = f'parameters "{first}" and "{name}" of sub-graph "{unit.name}" both set {target.text}'
                mistakes.append(_wrong(value.key, target, text, "give one of them"))
            elif target.stage in unit.replaced:
                text = f'parameter "{name}" of sub-graph "{unit.name}" sets "{target.text}"'
                remedy = "this stage is replaced by an input: remove the value"
                mistakes.append(_wrong(value.key, target, text, remedy))
            else:
                entry, found = unit.stages[target.stage], replace(value, place=place)
                unit.stages[target.stage] = with_value(entry, keys, (key,) * len(keys), found)


def _wrong(place: Place, target: InterfaceTarget, text: str, remedy: str) -> Mistake:
    """A mistake at a use of an interface, together with the place of the interface."""
    return Mistake(place.beside(target.node.place), text, remedy)


def _unknown(
    unit: Unit, noun: str, name: str, place: Place, known: Mapping[str, object], mistakes: list[Mistake]
) -> None:
    """Note a name that the interface lacks, unless that section of the file cannot be read."""
    if SECTION[noun] not in unit.file.unreadable:
        text = f'graph "{unit.file.name}", used as "{unit.name}", has no {noun} "{name}"'
        remedy = did_you_mean(name, known.keys(), f"{noun}s")
        mistakes.append(Mistake(place.beside(unit.file.place), text, remedy))


def _overlap(first: InterfaceTarget, second: InterfaceTarget) -> bool:
    """True if both name the same port, or one names the stage of the other's port."""
    return first.stage == second.stage and (first.name == second.name or None in (first.name, second.name))
