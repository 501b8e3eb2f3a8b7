"""What the interface of the graph file itself names; those of its sub-graphs show in what uses them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Literal

from followspot.errors import Mistake, did_you_mean
from followspot.graph.compose.interface import Target
from followspot.graph.compose.unit import Unit
from followspot.graph.names import below

Noun = Literal["parameter", "input", "output"]
Promise = tuple[Noun, Target]
"""A target with the full name of its stage, and its kind there."""


def promises_of(unit: Unit) -> tuple[Promise, ...]:
    """The targets that are stages themselves."""
    found = ((noun, target) for noun, target in _targets(unit) if target.stage not in unit.units)
    return tuple((noun, replace(target, stage=below(unit.name, target.stage))) for noun, target in found)


def check_nested(unit: Unit, mistakes: list[Mistake]) -> None:
    """Note targets that a sub-graph lacks."""
    for noun, target in _targets(unit):
        inner = next(iter(unit.units.get(target.stage, ())), None)
        known = {} if inner is None else _names(inner)[noun]
        if inner is not None and target.name is not None and target.name not in known:
            text = f'sub-graph "{inner.name}" has no {noun} "{target.name}"'
            place = target.node.place.beside(inner.file.place)
            mistakes.append(Mistake(place, text, did_you_mean(target.name, known.keys(), f"{noun}s")))


def _targets(unit: Unit) -> Iterator[Promise]:
    for noun, names in _names(unit).items():
        for target in (target for targets in names.values() for target in targets):
            yield noun, target


def _names(unit: Unit) -> dict[Noun, Mapping[str, tuple[Target, ...]]]:
    own = unit.interface
    return {"parameter": own.params, "input": own.inputs, "output": own.outputs}
