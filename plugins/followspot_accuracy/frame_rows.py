"""Rows of truth and of tracks, of which each object or person has one in a frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from followspot.csv_rows import Row
from followspot.errors import InputError, Mistake, Place
from followspot_accuracy.statistics import SAME, frames_of

Known = TypeVar("Known")


def not_empty(rows: Iterable[Known], *paths: Path) -> Sequence[Known]:
    """The rows of these files. Raises InputError if there are none: truth of nothing would score any run."""
    found = list(rows)
    if not found:
        names = ", ".join(map(str, paths))
        remedy = "give the file that was written with the recording"
        raise InputError([Mistake(None, f"{names} has no rows: there is nothing to score by", remedy)])
    return found


def one_in_a_frame(rows: Iterable[Row], column: str) -> Iterator[Row]:
    """The same rows, of truth; column: that of the objects or persons.

    Raises InputError after the last row if two are of one object and one frame: times that are written with
    too few digits make one frame of several.
    """
    return _distinct(rows, (column,), SAME, "write times with more digits, or remove one of the rows")


def one_at_a_time(rows: Iterable[Row], *columns: str) -> Iterator[Row]:
    """The same rows, of tracks or poses; columns: that of the objects or persons, and what tells rows apart.

    Raises InputError after the last row if two are of one object and one time: a second run wrote into the
    file, or two files were joined. Only equal times count: trackers of their own clocks may send twice within
    what counts as one frame of truth.
    """
    return _distinct(rows, columns, 0.0, "give the rows of one run, each of one time once")


def _distinct(rows: Iterable[Row], columns: Sequence[str], same: float, remedy: str) -> Iterator[Row]:
    """same: difference of times within a frame, s. Raises InputError after the last row."""
    time, names, lines, file = [], [], [], ""
    for row in rows:
        time.append(row.number("time"))
        names.append(tuple(map(row.cell, columns)))
        lines.append(row.line)
        file = row.file
        yield row
    _, frame = frames_of(np.array(time, "f8"), same)
    first: dict[tuple[int, tuple[str, ...]], int] = {}
    for number, name, line in zip(frame.tolist(), names, lines, strict=True):
        known = first.setdefault((number, name), line)
        if known != line:
            text = f'{columns[0]} "{name[0][:40]}" has a row of this frame already, in line {known}'
            raise InputError([Mistake(Place(file, line, 1), text, remedy)])
