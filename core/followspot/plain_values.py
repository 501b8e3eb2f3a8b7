"""Frozen dataclasses and named tuples as plain values, and back: for `Stage.state` and `Stage.restore`.

::

    def state(self) -> Any:
        return to_plain(self.people)

    def restore(self, state: Any) -> None:
        self.people = from_plain(list[Person], state)
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

_SCALARS = (bool, int, float, str)


def to_plain(value: Any) -> Any:
    """The value with mappings in place of dataclasses and named tuples: numbers, text, arrays, lists, dicts.

    Keys of mappings become text. A float that is not finite becomes an array without axes, because JSON has
    no such number.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return {name: to_plain(part) for name, part in value._asdict().items()}
    if isinstance(value, Mapping):
        return {str(key): to_plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return np.array(value)
    return value


def from_plain(kind: Any, value: Any) -> Any:
    """The value of a type that :func:`to_plain` made plain.

    kind: a dataclass or named tuple with types for its fields, an array, a number or text, or a list, tuple,
    dict or union with None of these. Arrays are copies. Raises TypeError if the type is another, TypeError,
    ValueError or KeyError if the value does not fit it.
    """
    origin, given = get_origin(kind) or kind, get_args(kind)
    if origin in (Union, UnionType):
        return _optional(given, value)
    if origin in _SCALARS:
        return origin(value)
    if origin is np.ndarray:
        return np.array(value)
    if origin in (list, tuple):
        return _sequence(origin, given, value)
    if origin is dict:
        key, part = given
        return {from_plain(key, name): from_plain(part, one) for name, one in value.items()}
    if is_dataclass(origin) or hasattr(origin, "_fields"):
        return _record(origin, given, value)
    raise TypeError(f"{kind} is no type of plain values")


def _optional(kinds: tuple[Any, ...], value: Any) -> Any:
    """None, or a value of the one type that is left."""
    rest = [kind for kind in kinds if kind is not NoneType]
    if len(rest) != 1:
        raise TypeError(f"{kinds} are several types: which one a plain value had is not known")
    return None if value is None else from_plain(rest[0], value)


def _sequence(kind: type, given: tuple[Any, ...], value: Any) -> Any:
    """A list or tuple, with one type for all parts or one for each."""
    if kind is list or given[1:] == (...,):
        return kind(from_plain(given[0], part) for part in value)
    return kind(from_plain(one, part) for one, part in zip(given, value, strict=True))


def _record(kind: Any, given: tuple[Any, ...], value: Mapping[str, Any]) -> Any:
    """A dataclass or named tuple. given: types in place of its type variables."""
    known = dict(zip(getattr(kind, "__parameters__", ()), given, strict=False))
    return kind(**{name: from_plain(_known(hint, known), value[name]) for name, hint in _hints(kind).items()})


def _known(hint: Any, known: Mapping[Any, Any]) -> Any:
    """The type of a field, for which a type variable may stand."""
    return known[hint] if isinstance(hint, TypeVar) else hint


@lru_cache
def _hints(kind: Any) -> Mapping[str, Any]:
    """The types of the fields of a dataclass or named tuple."""
    hints = get_type_hints(kind)
    names = kind._fields if hasattr(kind, "_fields") else [field.name for field in fields(kind)]
    return {name: hints[name] for name in names}
