"""Recorded messages as rows of a table."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from followspot import Room
from followspot.frame_times import to_seconds
from followspot.message_table import head_of, heading, rows_of, table_of
from followspot.messages import Message

TEXT = ""
"""Stands for the type of a column of texts."""
_HEAD = {"frame": "i8", "time": "f8"}
_TAIL = {"source": TEXT, "time_ns": "i8"}
_SCALARS: dict[Any, str] = {int: "i8", float: "f8", bool: "?"}


def headings(kind: type[Message], room: Room) -> dict[str, str]:
    """Names of a table's columns and their numpy type codes: the columns of `sinks.csv`, with all
    that the type's table has; then the source, and the capture time, exact, ns. Raises
    FollowspotError if two names are equal.
    """
    scalars = {heading(name): _SCALARS.get(scalar, TEXT) for name, scalar in kind.scalars}
    columns = {}
    for name, values, *_ in head_of(kind, room):
        code = values.dtype.str if isinstance(values, np.ndarray) and values.dtype != object else TEXT
        columns[name] = code or scalars.get(name, TEXT)
    return _HEAD | columns | _TAIL


def rows(message: Message, room: Room) -> Iterator[tuple[Any, ...]]:
    """The rows of one message; NaN is None, lists are JSON."""
    header = message.header
    for row in rows_of(table_of(message, room)):
        cells = (json.dumps(cell) if isinstance(cell, list | tuple) else cell for cell in row)
        yield (header.seq, to_seconds(header.time), *cells, header.source, header.time)
