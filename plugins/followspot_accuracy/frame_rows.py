"""Rows of truth, of which each object or person has one in a frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from followspot.csv_rows import Row
from followspot.errors import InputError, Mistake, Place
from followspot_accuracy.statistics import frames_of


def one_in_a_frame(rows: Iterable[Row], column: str) -> Iterator[Row]:
    """The same rows; column: that of the objects or persons.

    Raises InputError after the last row if two are of one object and one frame: times that are written with
    too few digits make one frame of several.
    """
    time, names, lines, file = [], [], [], ""
    for row in rows:
        time.append(row.number("time"))
        names.append(row.cell(column))
        lines.append(row.line)
        file = row.file
        yield row
    _, frame = frames_of(np.array(time, "f8"))
    first: dict[tuple[int, str], int] = {}
    for number, name, line in zip(frame.tolist(), names, lines, strict=True):
        known = first.setdefault((number, name), line)
        if known != line:
            text = f'{column} "{name[:40]}" has a row of this frame already, in line {known}'
            remedy = "write times with more digits, or remove one of the rows"
            raise InputError([Mistake(Place(file, line, 1), text, remedy)])
