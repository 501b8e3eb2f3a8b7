"""Tracks and ground truth as arrays, from CSV files or messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot.csv_rows import Row, read_rows
from followspot.frame_times import to_seconds
from followspot.inertial import PosedTruth
from followspot.messages import Array
from followspot.tracking import STATES, Truth
from followspot_accuracy.frame_rows import not_empty, one_at_a_time, one_in_a_frame
from followspot_accuracy.statistics import frames_of

TRACK_COLUMNS = ("time", "object", "state", "x", "y", "z")
TRUTH_COLUMNS = ("time", "object", "x", "y", "z", "hidden", "trackable", "pair")
QUATERNION = ("qw", "qx", "qy", "qz")
"""Columns of files with orientations."""
SIGMAS = ("sx", "sy", "sz")
"""Columns of files with uncertainties: one standard deviation along each axis, m."""


@dataclass(frozen=True, eq=False)
class TrackTable:
    """Positions that a tracker reported: N rows in any order.

    time: (N,) s; target: (N,) index of `objects`; state: (N,) index of `followspot.tracking.STATES`;
    xyz: (N, 3) m; quaternion: (N, 4) as in `followspot.inertial.PosedTracks`, None if the file has none;
    sigma: (N, 3) m, one standard deviation along each axis, NaN if unknown, None if the file has none.
    """

    objects: tuple[str, ...]
    time: Array
    target: Array
    state: Array
    xyz: Array
    quaternion: Array | None = None
    sigma: Array | None = None


@dataclass(frozen=True, eq=False)
class TruthTable:
    """True positions of M objects at F ascending times.

    time: (F,) s; xyz: (F, M, 3) m, NaN if an object is absent; hidden, trackable, pair: (F, M) as
    in `followspot.tracking.Truth`, False if an object is absent; quaternion: (F, M, 4), None if no
    orientation is known.
    """

    objects: tuple[str, ...]
    time: Array
    xyz: Array
    hidden: Array
    trackable: Array
    pair: Array
    quaternion: Array | None = None


def read_tracks_csv(path: Path) -> TrackTable:
    """Tracks as `sinks.csv` writes them; more columns are ignored. Raises InputError with line numbers."""
    found = one_at_a_time(read_rows(path, TRACK_COLUMNS, (*QUATERNION, *SIGMAS)), "object")
    rows = [
        (
            row.number("time"),
            row.text("object"),
            row.choice("state", STATES),
            row.numbers("x", "y", "z"),
            _optional(row, QUATERNION),
            _sigmas(row),
        )
        for row in found
    ]
    objects = tuple(dict.fromkeys(row[1] for row in rows))
    return TrackTable(
        objects,
        np.array([r[0] for r in rows], "f8"),
        np.array([objects.index(r[1]) for r in rows], "i4"),
        np.array([r[2] for r in rows], "u1"),
        np.array([r[3] for r in rows], "f8").reshape(-1, 3),
        _known(np.array([r[4] for r in rows], "f8").reshape(-1, 4)),
        _known(np.array([r[5] for r in rows], "f8").reshape(-1, 3)),
    )


def read_truth_csv(path: Path) -> TruthTable:
    """Truth with the columns of `TRUTH_COLUMNS`, more are ignored. Raises InputError with line numbers."""
    rows = one_in_a_frame(read_rows(path, TRUTH_COLUMNS, QUATERNION), "object")
    return _truth_table(not_empty(map(_truth_row, rows), path))


def truth_of(messages: Iterable[Truth]) -> TruthTable:
    """Truth as a `room.truth` source gives it, one message per frame."""
    return _truth_table(
        (
            to_seconds(m.header.time),
            name,
            m.xyz[i],
            (m.hidden[i], m.trackable[i], m.pair[i]),
            m.quaternion[i] if isinstance(m, PosedTruth) else UNKNOWN,
        )
        for m in messages
        for i, name in enumerate(m.objects)
    )


_TruthRow = tuple[float, str, Array, tuple[bool, bool, bool], Array]
UNKNOWN = np.full(4, np.nan)


def _truth_row(row: Row) -> _TruthRow:
    flags = (row.flag("hidden"), row.flag("trackable"), row.flag("pair"))
    return (
        row.number("time"),
        row.text("object"),
        np.array(row.numbers("x", "y", "z")),
        flags,
        _optional(row, QUATERNION),
    )


def _optional(row: Row, columns: Sequence[str]) -> Array:
    """The numbers that a row has in these columns; NaN if it has none."""
    if not all(map(row.has, columns)) or not all(map(row.cell, columns)):
        return np.full(len(columns), np.nan)
    if row.cell(columns[0]).lower() == "nan":
        return np.full(len(columns), np.nan)
    return np.array(row.numbers(*columns))


def _sigmas(row: Row) -> Array:
    """The standard deviations of a row; NaN if it has none. Raises InputError if one is negative."""
    values = _optional(row, SIGMAS)
    for column, value in zip(SIGMAS, values, strict=True):
        if value < 0:
            raise row.mistake(column, "a number from 0")
    return values


def _known(values: Array) -> Array | None:
    """The values, if any is known."""
    return values if np.isfinite(values).any() else None


def _truth_table(rows: Iterable[_TruthRow]) -> TruthTable:
    """Sort rows into frames by their time; a later row of the same frame and object replaces the earlier."""
    known = list(rows)
    objects = tuple(dict.fromkeys(row[1] for row in known))
    time, frame = frames_of(np.array([r[0] for r in known], "f8"))
    xyz = np.full((len(time), len(objects), 3), np.nan)
    flags = np.zeros((len(time), len(objects), 3), bool)
    quaternion = np.full((len(time), len(objects), 4), np.nan)
    columns = {name: i for i, name in enumerate(objects)}
    for f, (_, name, position, marks, turn) in zip(frame, known, strict=True):
        xyz[f, columns[name]] = position
        flags[f, columns[name]] = marks
        quaternion[f, columns[name]] = turn
    return TruthTable(objects, time, xyz, flags[..., 0], flags[..., 1], flags[..., 2], _known(quaternion))
