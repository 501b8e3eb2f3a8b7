"""The parameters and ports of stages that the interfaces of graph files name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.compose.interface import SECTION, InterfaceTarget
from followspot.graph.compose.unit import Unit
from followspot.graph.names import below
from followspot.yaml.node import child

Noun = Literal["parameter", "input", "output"]


@dataclass(frozen=True)
class StageTarget:
    """A parameter or a port of a stage that an interface names.

    target: with the full name of its stage; uses: the plugin stage that the file names there.
    """

    noun: Noun
    target: InterfaceTarget
    uses: str


def stage_targets(unit: Unit) -> tuple[StageTarget, ...]:
    """The targets that are stages themselves, of a unit and of all below it."""
    found = []
    for noun, target in _targets(unit):
        if target.stage not in unit.units:
            uses = child(unit.stages[target.stage], "uses")
            full = replace(target, stage=below(unit.name, target.stage))
            found.append(StageTarget(noun, full, str(uses.value) if uses is not None else ""))
    return (*found, *(target for inner in _inner(unit) for target in stage_targets(inner)))


def check_nested(unit: Unit, mistakes: list[Mistake]) -> None:
    """Note targets that a sub-graph lacks, of a unit and of all below it, unless they are noted already."""
    for noun, target in _targets(unit):
        inner = next(iter(unit.units.get(target.stage, ())), None)
        known = {} if inner is None else _names(inner)[noun]
        if inner is None or target.name is None or target.name in known or is_noted(target, mistakes):
            continue
        if SECTION[noun] in inner.file.unreadable:
            continue
        text = f'sub-graph "{inner.name}" has no {noun} "{target.name}"'
        place = target.node.place.beside(inner.file.place)
        mistakes.append(Mistake(place, text, did_you_mean(target.name, known.keys(), f"{noun}s")))
    for found in _inner(unit):
        check_nested(found, mistakes)


def is_noted(target: InterfaceTarget, mistakes: list[Mistake]) -> bool:
    """Whether one of the mistakes shows the place of a target."""
    at = _position(target.node.place)
    return any(
        at in map(_position, (mistake.place, *mistake.place.outer_places))
        for mistake in mistakes
        if mistake.place is not None
    )


def _position(place: Place) -> tuple[str, int, int]:
    return place.file, place.line, place.column


def _inner(unit: Unit) -> Iterator[Unit]:
    return (inner for found in unit.units.values() for inner in found)


def _targets(unit: Unit) -> Iterator[tuple[Noun, InterfaceTarget]]:
    for noun, names in _names(unit).items():
        for target in (target for targets in names.values() for target in targets):
            yield noun, target


def _names(unit: Unit) -> dict[Noun, Mapping[str, tuple[InterfaceTarget, ...]]]:
    own = unit.interface
    return {"parameter": own.params, "input": own.inputs, "output": own.outputs}
