"""Messages as rows of plain values: of tables, and of JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from followspot.errors import FollowspotError
from followspot.messages import Array, Column, Message

TEXT = ""
"""Stands for the type of a column of texts."""
_HEAD = {"seq": "i8", "time_ns": "i8", "source": TEXT}
_SCALARS: dict[Any, str] = {int: "i8", float: "f8", bool: "?"}


def headings(kind: type[Message]) -> dict[str, str]:
    """Names of a table's columns and their numpy type codes; `xyz` (N, 3) becomes xyz_0, xyz_1, xyz_2.

    A table has a row for each row of the message's first column. A column of another length, or with
    another variable size, becomes JSON in one column. Raises FollowspotError if two names are equal.
    """
    scalars = {name: _SCALARS.get(scalar, TEXT) for name, scalar in kind.scalars}
    columns = {
        name: column.dtype.str if _spread(kind, column) else TEXT
        for column in kind.columns
        for name in _names(kind, column)
    }
    found = _HEAD | scalars | columns
    if len(found) < len(_HEAD) + len(scalars) + len(columns):
        raise FollowspotError(f"{kind.__name__} has a field named like another column; export it to jsonl")
    return found


def rows(message: Message) -> Iterator[tuple[Any, ...]]:
    """The rows of one message; NaN is None."""
    kind = type(message)
    scalars = [_plain(getattr(message, name)) for name, _ in kind.scalars]
    head = (message.header.seq, message.header.time, message.header.source, *scalars)
    count = len(getattr(message, kind.columns[0].name)) if kind.columns else 1
    cells = [cell for column in kind.columns for cell in _cells(kind, column, message, count)]
    for number in range(count):
        yield (*head, *(cell[number] for cell in cells))


def as_json(message: Message) -> dict[str, Any]:
    """The message as JSON types, arrays as nested lists; NaN is None."""
    source, seq, time, _ = message.header
    fields = {name: _finite(getattr(message, name)) for name, _ in message.scalars}
    arrays = {column.name: _nested(getattr(message, column.name)) for column in message.columns}
    return {"type": type(message).__name__, "source": source, "seq": seq, "time": time} | fields | arrays


def _spread(kind: type[Message], column: Column) -> bool:
    """True if a column has a cell for each of its numbers."""
    sizes = column.shape[1:]
    return column.shape[:1] == kind.columns[0].shape[:1] and not any(isinstance(s, str) for s in sizes)


def _names(kind: type[Message], column: Column) -> list[str]:
    if not _spread(kind, column):
        return [column.name]
    sizes = [range(int(size)) for size in column.shape[1:]]
    return ["_".join((column.name, *map(str, at))) for at in product(*sizes)]


def _cells(kind: type[Message], column: Column, message: Message, count: int) -> list[list[Any]]:
    """Table columns, each with `count` cells."""
    array: Array = getattr(message, column.name)
    if _spread(kind, column):
        flat = array.reshape(count, -1) if array.size else np.zeros((count, len(_names(kind, column))))
        return [_nested(flat[:, i]) for i in range(flat.shape[1])]
    if column.shape[:1] == kind.columns[0].shape[:1]:
        return [[json.dumps(row) for row in _nested(array)]]
    return [[json.dumps(_nested(array))] * count]


def _plain(value: Any) -> Any:
    return json.dumps(value) if isinstance(value, tuple) else _finite(value)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _nested(array: Array) -> list[Any]:
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        unknown = ~np.isfinite(array)
        array = array.astype(object)
        array[unknown] = None
    return list(array.tolist())
