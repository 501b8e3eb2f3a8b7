"""Figures of messages that browsers plot: any number, in any row, of any port. Only the newest is kept."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from followspot.errors import FollowspotError
from followspot.message_table import head_of, table_of
from followspot.messages import Message
from followspot.room import Room
from followspot.tables.table_column import TableColumn
from followspot_dashboard.picture import PICTURES
from followspot_page.allowed_requests import Curve
from followspot_page.display.feed import Feed

ROWS = "rows"
"""The field that is the number of rows; no column of a table has this name."""
KEYS = ("object", "target", "person")
"""Columns that name the rows of a table, the first that it has."""
MOST_PORTS = 32
"""Ports that all browsers plot figures of at once."""


class Curves:
    """The figures that browsers plot. feed: gets their newest values; room: has the names in tables."""

    def __init__(self, feed: Feed, room: Room) -> None:
        self._feed = feed
        self._room = room
        self._chosen: dict[object, tuple[Curve, ...]] = {}
        """By browser."""
        self._by_port: dict[str, tuple[Curve, ...]] = {}

    @property
    def ports(self) -> frozenset[str]:
        """The ports of the figures that are plotted."""
        return frozenset(self._by_port)

    def choose(self, browser: object, curves: Sequence[Curve], known: Collection[str]) -> None:
        """Replace the curves that a browser plots. known: ports with figures. Raises FollowspotError."""
        for curve in curves:
            if curve.port not in known:
                raise FollowspotError(f"there is no port {curve.port} whose figures this page plots")
        others = (curve for one, chosen in self._chosen.items() if one is not browser for curve in chosen)
        if len({curve.port for curve in (*others, *curves)}) > MOST_PORTS:
            raise FollowspotError(f"browsers plot figures of {MOST_PORTS} ports already")
        self._chosen[browser] = tuple(curves)
        self._sort()

    def leave(self, browser: object) -> None:
        """Forget the curves of a browser that has left."""
        if self._chosen.pop(browser, None):
            self._sort()

    def take(self, port: str, message: Message) -> None:
        """Take a message of a port; without a plot of the port it has no effect."""
        curves = self._by_port.get(port)
        if curves is not None:
            found = values_of(message, curves, self._room)
            values = [[c.row, c.field, value] for c, value in zip(curves, found, strict=True)]
            data = {"type": "curves", "port": port, "time": message.header.time / 1e6, "values": values}
            self._feed.put(f"curves {port}", json.dumps(data, separators=(",", ":")))

    def _sort(self) -> None:
        wanted = dict.fromkeys(curve for curves in self._chosen.values() for curve in curves)
        self._by_port = {
            port: tuple(c for c in wanted if c.port == port) for port in {c.port for c in wanted}
        }


def figures(ports: Mapping[str, type[Message]], room: Room) -> dict[str, Any]:
    """The ports whose messages have numbers, each with the name of its type, and what each type has.

    fields: name and unit of each number; rows: "" for a message of one row, "target" if targets name them,
    else "number".
    """
    kinds: dict[str, dict[str, Any]] = {}
    for kind in set(ports.values()):
        with suppress(FollowspotError):  # a type whose table has two columns of one name
            if not issubclass(kind, PICTURES) and (fields := _fields(kind, head_of(kind, room))):
                kinds[_name(kind)] = {"fields": fields, "rows": _naming(kind, room)}
    return {
        "ports": {port: _name(kind) for port, kind in ports.items() if _name(kind) in kinds},
        "kinds": dict(sorted(kinds.items())),
    }


def _name(kind: type[Message]) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def values_of(message: Message, curves: Sequence[Curve], room: Room) -> list[float | None]:
    """The value of each figure in a message; None if it is not there, or no finite number."""
    table = {cells.name: cells.values for cells in table_of(message, room)}
    count = len(next(iter(table.values()), ()))
    keys = next((table[name] for name in KEYS if name in table), range(count))
    rows = {str(key): row for row, key in reversed(list(enumerate(keys)))} if message.columns else {"": 0}
    return [
        float(count) if c.field == ROWS else _number(table.get(c.field, ()), rows.get(c.row)) for c in curves
    ]


def _number(values: Any, row: int | None) -> float | None:
    value = values[row] if row is not None and row < len(values) else None
    if not isinstance(value, int | float | np.number | np.bool_):
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def _fields(kind: type[Message], table: Sequence[TableColumn]) -> list[dict[str, str]]:
    plain = {name for name, its in kind.scalars if its in (int, float, bool)}
    numbers = [
        {"name": cells.name, "unit": "" if cells.unit == "1" else cells.unit}
        for cells in table
        if cells.name in plain or (isinstance(cells.values, np.ndarray) and cells.values.dtype.kind in "fiub")
    ]
    return [*numbers, {"name": ROWS, "unit": ""}] if kind.columns else numbers


def _naming(kind: type[Message], room: Room) -> str:
    if not kind.columns:
        return ""
    names = {cells.name for cells in head_of(kind, room)}
    return "target" if names & {"object", "target"} else "number"
