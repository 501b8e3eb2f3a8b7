"""Axes of a sweep: `STAGE.KEY=A,B,C` and `STAGE.KEY=START:STOP:STEP`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from itertools import product
from math import prod

from followspot.errors import InputError, Mistake, Place

MAX_POINTS = 10_000
_COMMA = re.compile(r",(?![^\[{]*[\]}])")
"""A comma that is not inside a list or a map."""


@dataclass(frozen=True)
class Axis:
    """A parameter, STAGE.KEY, and the values that it takes, as they are written."""

    name: str
    values: tuple[str, ...]


Point = tuple[tuple[str, str], ...]
"""Name and value of each axis."""


def read_axes(options: Sequence[str]) -> tuple[Axis, ...]:
    """The axes of the grid, including those with one value. Raises InputError with every mistake."""
    mistakes: list[Mistake] = []
    axes = tuple(axis for option in options if (axis := _axis(option, mistakes)) is not None)
    names = [axis.name for axis in axes]
    twice = dict.fromkeys(name for name in names if names.count(name) > 1)
    mistakes += [Mistake(None, f"--set {name} is given twice", "write its values into one") for name in twice]
    if not mistakes and not any(len(axis.values) > 1 for axis in axes):
        remedy = "give a --set several values: --set fuse.bandwidth_scale=2,3,4"
        mistakes.append(Mistake(None, "there is nothing to sweep", remedy))
    count = prod(len(axis.values) for axis in axes)
    if count > MAX_POINTS:
        mistakes.append(Mistake(None, f"the grid has {count} points", f"at most {MAX_POINTS}"))
    if mistakes:
        raise InputError(mistakes)
    return axes


def points(axes: Sequence[Axis]) -> list[Point]:
    """Every combination; the last axis varies fastest."""
    return [
        tuple(zip((axis.name for axis in axes), values, strict=True))
        for values in product(*(axis.values for axis in axes))
    ]


def _axis(option: str, mistakes: list[Mistake]) -> Axis | None:
    name, sign, text = option.partition("=")
    place = Place("--set", 1, 1, max(1, len(name)), option or " ")
    if not sign or not name or not text:
        example = "STAGE.KEY=A,B,C or STAGE.KEY=START:STOP:STEP"
        mistakes.append(Mistake(place, f'"{option}" is nothing to sweep', f"write {example}"))
        return None
    numbers = [_number(part) for part in text.split(":")]
    if None in numbers or len(numbers) not in (2, 3):
        return Axis(name, tuple(dict.fromkeys(value.strip() for value in _COMMA.split(text))))
    values = _range([number for number in numbers if number is not None])
    if not values:
        remedy = f"START:STOP:STEP leads from START to STOP in at most {MAX_POINTS} steps"
        mistakes.append(Mistake(place, f'"{text}" is no range', remedy))
        return None
    return Axis(name, values)


def _range(numbers: Sequence[Decimal]) -> tuple[str, ...]:
    """START, START + STEP, ... up to STOP; nothing if that is no range, or has too many values."""
    if len(numbers) != 3 or not all(number.is_finite() for number in numbers):
        return ()
    start, stop, step = numbers
    try:
        steps = (stop - start) / step
        if not 0 <= steps <= MAX_POINTS:
            return ()
        return tuple(f"{start + number * step}" for number in range(int(steps) + 1))
    except ArithmeticError:  # a step of 0, or an exponent beyond all bounds
        return ()


def _number(text: str) -> Decimal | None:
    try:
        return Decimal(text.strip())
    except InvalidOperation:
        return None
