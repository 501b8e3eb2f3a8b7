"""Messages as tables and as JSON, with names of targets, cameras and states instead of their indices.

The declaration of a message type says its table: a row for each row of its first column, a table column for
each number of a row. A type whose table is another one overrides `Message.as_table`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from followspot.columns import Column
from followspot.errors import FollowspotError
from followspot.messages import Array, Message
from followspot.room import Room
from followspot.tables.table_column import TableColumn
from followspot.tracking import STATES

Table = Sequence[TableColumn]
RESERVED = frozenset({"type", "source", "seq", "frame", "time", "time_ns", "rows"})
"""Names that files and JSON use beside the table; a field with such a name becomes `message_time`."""


def table_of(message: Message, room: Room) -> Table:
    """The columns of a message's table, all equally long; of an empty message: the names of any."""
    own = message.as_table(room)
    return own if own is not None else _declared(message, room)


def rows_of(table: Table) -> Iterator[tuple[Any, ...]]:
    """The rows of a table in plain Python values; an unknown number is None."""
    return zip(*(plain(cells.values) for cells in table), strict=True)


def head_of(kind: type[Message], room: Room) -> Table:
    """The columns of a message type's table, without rows. Raises FollowspotError if two names are equal."""
    table = table_of(kind.empty(), room)
    names = [cells.name for cells in table]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise FollowspotError(
            f"the table of {kind.__name__} has two columns {twice}; give them names: column(..., names=...)"
        )
    return table


def as_json(message: Message, room: Room) -> dict[str, Any]:
    """The message in JSON types: type, source, seq, time (ns), single values, and an object for each row."""
    source, seq, time, _ = message.header
    fields = {heading(name): _finite(getattr(message, name)) for name, _ in message.scalars}
    found = {"type": type(message).__name__, "source": source, "seq": seq, "time": time} | fields
    if message.columns:
        table = [cells for cells in table_of(message, room) if cells.name not in fields]
        names = [cells.name for cells in table]
        found["rows"] = [dict(zip(names, row, strict=True)) for row in rows_of(table)]
    return found


def plain(values: Array | list[Any]) -> list[Any]:
    """Values in JSON types; NaN and infinity become None, and a complex number its two parts."""
    if not isinstance(values, np.ndarray):
        return values
    if values.dtype.kind == "c":
        values = np.stack([values.real, values.imag], axis=-1)
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        unknown = ~np.isfinite(values)
        values = values.astype(object)
        values[unknown] = None
    return list(values.tolist())


def named_columns(kind: type[Message]) -> dict[str, tuple[Column, int]]:
    """The table columns that a type's declaration says, by name: a column of the message, and which of the
    numbers in its rows; names as in files and JSON.
    """
    columns = _layout(kind).columns  # type: ignore[arg-type]  # classes can be hashed
    return {head: (column, index) for column, heads in columns for index, head in enumerate(heads)}


class _Layout(NamedTuple):
    """The layout of the table of a message type, from its declaration.

    single: fields without rows that are columns; by_target: whether row i is target i; columns: each with the
    names of its table columns, or with none if a row of it is a text or a list.
    """

    single: tuple[str, ...]
    by_target: bool
    columns: tuple[tuple[Column, tuple[str, ...]], ...]


@lru_cache(maxsize=1024)
def _layout(kind: type[Message]) -> _Layout:
    referred = {column.refers for column in kind.columns}
    single = tuple(name for name, _ in kind.scalars if name not in referred)
    by_target = kind.columns[:1] != () and kind.columns[0].shape[:1] == ("T",) and "targets" not in referred
    heads = {column: _heads(kind, column) for column in kind.columns}
    count = Counter(head for each in (single, *heads.values()) for head in each)
    taken = RESERVED | {head for head, times in count.items() if times > 1}
    return _Layout(
        single, by_target, tuple((column, _apart(column, each, taken)) for column, each in heads.items())
    )


def _apart(column: Column, heads: tuple[str, ...], taken: Collection[str]) -> tuple[str, ...]:
    """Names of table columns that no other has: xy_x for x, message_time for time.

    Names that the declaration gives (`names`) stay.
    """
    if column.names or not any(head in taken for head in heads):
        return heads
    return tuple(heading(head) if head == column.name else f"{column.name}_{head}" for head in heads)


def heading(name: str) -> str:
    """The name of a field in tables and JSON: another one if files write a column of their own with its."""
    return f"message_{name}" if name in RESERVED else name


def _heads(kind: type[Message], column: Column) -> tuple[str, ...]:
    """Names of the table columns of a column: x, y, z for `xyz`; sigma_0, sigma_1, ... for `sigma`.

    None if its rows have no fixed number of numbers.
    """
    sizes = [size for size in column.shape[1:] if isinstance(size, int)]
    rows = column.shape[:1] in ((), kind.columns[0].shape[:1])  # a single number is that of each row
    if not rows or len(sizes) < len(column.shape) - 1:
        return ()
    if column.names:
        return column.names
    if not sizes:
        return ("object",) if column.refers == "targets" else (column.name,)
    if len(sizes) == 1 and len(column.name) == sizes[0]:
        return tuple(column.name)
    return tuple("_".join((column.name, *map(str, at))) for at in product(*map(range, sizes)))


def _declared(message: Message, room: Room) -> Table:
    """The table that the declaration of the type says."""
    layout = _layout(type(message))  # type: ignore[arg-type]  # classes can be hashed
    has_rows = message.columns and message.columns[0].shape
    count = len(getattr(message, message.columns[0].name)) if has_rows else 1
    table = [TableColumn(heading(name), [_finite(getattr(message, name))] * count) for name in layout.single]
    if layout.by_target:
        table.append(TableColumn("object", _named(np.arange(count), tuple(room.targets))))
    for column, heads in layout.columns:
        array: Array = getattr(message, column.name)
        if not heads:
            table.append(
                TableColumn(
                    heading(column.name),
                    _rows(message, column, count, room),
                    column.unit,
                    extra=column.extra,
                )
            )
            continue
        names = _known(message, column.refers, room)
        rows = array.reshape(count, len(heads)) if column.shape else np.full((count, 1), array)
        for head, values in zip(heads, rows.T, strict=True):
            shown = plain(values) if values.dtype.kind == "c" else values
            named = shown if names is None else _named(values, names)
            table.append(TableColumn(head, named, column.unit, column.decimals, column.extra))
    return table


def _rows(message: Message, column: Column, count: int, room: Room) -> list[Any]:
    """A text or a list for each row: names of targets, numbers, or all of a column that has other rows."""
    array: Array = getattr(message, column.name)
    if column.shape[:1] != message.columns[0].shape[:1]:
        return [plain(array)] * count
    if column.shape[1:] != ("T",) or array.dtype.kind != "b":
        return plain(array)
    members = np.array(_named(np.arange(array.shape[1]), tuple(room.targets)), object)
    return [" ".join(members[row]) for row in array]


def _known(message: Message, refers: str, room: Room) -> Sequence[str] | None:
    """The names that indices stand for; None for numbers that are no indices."""
    if not refers:
        return None
    if refers in ("targets", "states"):
        return tuple(room.targets) if refers == "targets" else STATES
    found: Sequence[str] = getattr(message, refers)
    return found


def _named(indices: Array, names: Sequence[str]) -> list[str]:
    """The name that each index stands for; the number itself if it stands for none."""
    return [names[i] if 0 <= i < len(names) else str(i) for i in indices.tolist()]


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
