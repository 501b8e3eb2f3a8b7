"""Tracks and ground truth as arrays, from CSV files or messages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot.csv_rows import Row, read_rows
from followspot.messages import Array
from followspot.tracking import STATES, Truth

TRACK_COLUMNS = ("frame", "time", "object", "state", "x", "y", "z")
TRUTH_COLUMNS = ("frame", "time", "object", "x", "y", "z", "hidden", "trackable", "pair")


@dataclass(frozen=True, eq=False)
class TrackTable:
    """Positions that a tracker reported: N rows in any order.

    time: (N,) s; target: (N,) index of `objects`; state: (N,) index of `followspot.tracking.STATES`;
    xyz: (N, 3) m.
    """

    objects: tuple[str, ...]
    time: Array
    target: Array
    state: Array
    xyz: Array


@dataclass(frozen=True, eq=False)
class TruthTable:
    """True positions of M objects at F ascending times.

    time: (F,) s; xyz: (F, M, 3) m, NaN if an object is absent; hidden, trackable, pair: (F, M) as
    in `followspot.tracking.Truth`, False if an object is absent.
    """

    objects: tuple[str, ...]
    time: Array
    xyz: Array
    hidden: Array
    trackable: Array
    pair: Array


def read_tracks_csv(path: Path) -> TrackTable:
    """Tracks as `sinks.csv` writes them; more columns are ignored. Raises InputError with line numbers."""
    rows = [
        (row.number("time"), row.text("object"), row.choice("state", STATES), row.numbers("x", "y", "z"))
        for row in read_rows(path, TRACK_COLUMNS)
    ]
    objects = tuple(dict.fromkeys(name for _, name, _, _ in rows))
    return TrackTable(
        objects,
        np.array([r[0] for r in rows], "f8"),
        np.array([objects.index(r[1]) for r in rows], "i4"),
        np.array([r[2] for r in rows], "u1"),
        np.array([r[3] for r in rows], "f8").reshape(-1, 3),
    )


def read_truth_csv(path: Path) -> TruthTable:
    """Truth with the columns of `TRUTH_COLUMNS`, more are ignored. Raises InputError with line numbers."""
    return _truth_table(_truth_row(row) for row in read_rows(path, TRUTH_COLUMNS))


def truth_of(messages: Iterable[Truth]) -> TruthTable:
    """Truth as a `room.truth` source gives it, one message per frame."""
    return _truth_table(
        (m.header.time / 1e9, name, m.xyz[i], (m.hidden[i], m.trackable[i], m.pair[i]))
        for m in messages
        for i, name in enumerate(m.objects)
    )


_TruthRow = tuple[float, str, Array, tuple[bool, bool, bool]]


def _truth_row(row: Row) -> _TruthRow:
    flags = (row.flag("hidden"), row.flag("trackable"), row.flag("pair"))
    return row.number("time"), row.text("object"), np.array(row.numbers("x", "y", "z")), flags


def _truth_table(rows: Iterable[_TruthRow]) -> TruthTable:
    """Sort rows into frames by their time; a later row of the same frame and object replaces the earlier."""
    known = list(rows)
    objects = tuple(dict.fromkeys(name for _, name, _, _ in known))
    time, frame = np.unique(np.array([r[0] for r in known], "f8"), return_inverse=True)
    xyz = np.full((len(time), len(objects), 3), np.nan)
    flags = np.zeros((len(time), len(objects), 3), bool)
    columns = {name: i for i, name in enumerate(objects)}
    for f, (_, name, position, marks) in zip(frame, known, strict=True):
        xyz[f, columns[name]] = position
        flags[f, columns[name]] = marks
    return TruthTable(objects, time, xyz, flags[..., 0], flags[..., 1], flags[..., 2])
