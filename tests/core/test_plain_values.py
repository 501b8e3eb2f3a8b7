"""Dataclasses and named tuples as plain values that travel, and back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, NamedTuple, TypeVar

import numpy as np
import pytest
from tests.travelled import travelled

from followspot import Array
from followspot.plain_values import from_plain, to_plain

T = TypeVar("T")


class Reading(NamedTuple):
    time: int
    value: float


@dataclass(frozen=True, eq=False)
class Part:
    place: Array
    readings: tuple[Reading, ...] = ()


@dataclass(frozen=True)
class Held(Generic[T]):
    one: T
    count: int


@dataclass(frozen=True, eq=False)
class Whole:
    name: str
    parts: dict[int, Part]
    nearest: Part | None
    sigma: float = float("inf")
    pair: tuple[int, float] = (1, 2.0)
    flags: list[bool] = field(default_factory=lambda: [True, False])


def test_nested_values_come_back_with_their_types_on_the_other_side():
    part = Part(np.arange(6.0).reshape(2, 3), (Reading(1 << 60, 0.1), Reading(2, -0.0)))
    whole = Whole("a", {3: part, -4: Part(np.zeros((0, 3), np.float32))}, part)
    back = from_plain(Whole, travelled(to_plain(whole)))
    assert (back.name, back.pair, back.flags, back.sigma) == ("a", (1, 2.0), [True, False], np.inf)
    assert type(back.flags[0]) is bool
    assert back.parts[3].readings == part.readings
    assert isinstance(back.parts[3].readings[0], Reading)
    for made, told in ((part, back.nearest), (part, back.parts[3]), (whole.parts[-4], back.parts[-4])):
        np.testing.assert_array_equal(made.place, told.place)
        assert made.place.dtype == told.place.dtype
    assert back.nearest.place.flags.writeable


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan])
def test_numbers_that_json_lacks_travel(value):
    back = from_plain(list[Reading], travelled(to_plain([Reading(1, value)])))
    assert isinstance(back[0].value, float)
    np.testing.assert_equal(back[0].value, value)


def test_none_stays_none_and_a_type_variable_is_what_it_stands_for():
    assert from_plain(Whole, travelled(to_plain(Whole("", {}, None)))).nearest is None
    held = from_plain(Held[Part], travelled(to_plain(Held(Part(np.ones(2)), 3))))
    assert isinstance(held.one, Part)
    assert held.count == 3


@pytest.mark.parametrize(
    ("kind", "value", "error"),
    [
        (Reading, {"time": 1}, KeyError),
        (tuple[int, float], [1], ValueError),
        (int | str, 1, TypeError),
        (object, 1, TypeError),
        (dict[int, float], {"x": 1.0}, ValueError),
    ],
)
def test_what_does_not_fit_is_an_error(kind, value, error):
    with pytest.raises(error):
        from_plain(kind, value)
