"""The figures that a condition may speak of: fields of a port's messages, and the ledger of its edges."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from followspot.columns import Column
from followspot.graph.plan import PlannedEdge
from followspot.library.handle import LOSSES, SOURCE_LOSSES, EdgeCount
from followspot.message_table import heading, named_columns
from followspot.messages import Array, Message
from followspot.room import Room
from followspot.tracking import STATES

Kind = Literal["number", "truth", "word"]
"""word: a text, or a number that stands for a name."""
LEDGER = (*LOSSES, *SOURCE_LOSSES)
ROWS = "rows"


@dataclass(frozen=True)
class Figure:
    """A figure of each message. of: its values, one for each row or a single one; words: the names that
    numbers stand for, none for a text that may be any.
    """

    kind: Kind
    of: Callable[[Message], Any]
    words: tuple[str, ...] = ()
    text: bool = False


def figures_of(kind: type[Message], room: Room) -> dict[str, Figure]:
    """The figures of a message type by name: its single values, and the columns of its table."""
    found = {ROWS: Figure("number", _rows)}
    for name, given in kind.scalars:
        if given in (int, float):
            found[heading(name)] = Figure("number", _single(name))
        elif given is bool:
            found[heading(name)] = Figure("truth", _single(name))
        elif given is str:
            found[heading(name)] = Figure("word", _single(name), text=True)
    for name, (column, index) in named_columns(kind).items():
        found[name] = _figure(column, index, room)
        if column.name not in found and len(column.shape) == 1:
            found[column.name] = found[name]
    return found


def losses(edges: Iterable[tuple[PlannedEdge, EdgeCount]], port: str) -> Mapping[str, int]:
    """The sums of each column of losses over all edges from a port."""
    counts = [count for edge, count in edges if f"{edge.from_stage}.{edge.from_port}" == port]
    return {name: sum(getattr(count, name) for count in counts) for name in LEDGER}


def _figure(column: Column, index: int, room: Room) -> Figure:
    words = {"states": STATES, "targets": tuple(room.targets)}.get(column.refers, ())
    kind: Kind = "word" if words else "truth" if column.dtype.kind == "b" else "number"
    return Figure(kind, _part(column.name, index, number=kind == "number"), words)


def _part(name: str, index: int, *, number: bool) -> Callable[[Message], Array]:
    def values(message: Message) -> Array:
        array = np.atleast_1d(getattr(message, name))
        part = array.reshape(len(array), -1)[:, index] if len(array) else array.reshape(-1)[:0]
        return part.astype("f8") if number else part  # no sum or sign wraps around

    return values


def _single(name: str) -> Callable[[Message], Any]:
    return lambda message: getattr(message, name)


def _rows(message: Message) -> int:
    if not message.columns:
        return 1
    return len(np.atleast_1d(getattr(message, message.columns[0].name)))
