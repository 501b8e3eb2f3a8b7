"""The pictures of one camera in a table of time stamps, as caliscope writes it beside its recordings."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from followspot.csv_rows import Row, read_rows
from followspot.errors import InputError, Mistake, Place

COLUMNS = ("sync_index", "cam_id", "frame_index", "frame_time")


@dataclass(frozen=True)
class RecordedPicture:
    """A row of the table: the moment that it belongs to, and its capture time, ns; None if not written."""

    line: int
    moment: int | None
    number: int | None
    time: int | None


def read_table(path: Path, camera: str, needed: Collection[str]) -> list[RecordedPicture]:
    """The recorded pictures of a camera in the order of the recording.

    A row stands for one recorded picture, so the k-th row of a camera is the k-th picture of its recording,
    whatever its frame_index counts from. Rows are in the order of frame_index, without it of frame_time, else
    of sync_index. camera: its name, which cam_id gives, or N for cam_N and camN; needed: of `COLUMNS`, beside
    cam_id. Raises InputError with file, line and remedy: for a row that cannot be read, a camera without
    rows, two rows of one picture, and times that contradict the numbers.
    """
    wanted = ("cam_id", *needed)
    optional = [name for name in COLUMNS if name not in wanted]
    meant = [_picture(row) for row in read_rows(path, wanted, optional) if is_id(row.cell("cam_id"), camera)]
    if not meant:
        place = Place(str(path), 1, 1)
        text = f"no row of camera {camera}"
        raise InputError([Mistake(place, text, "cam_id is a camera's name, or N for cam_N")])
    return _in_order(path, meant)


def is_id(text: str, camera: str) -> bool:
    """Whether a cam_id means this camera."""
    return camera in (text, f"cam_{text}", f"cam{text}")


def _picture(row: Row) -> RecordedPicture:
    """A row. Raises InputError."""
    moment, number = (row.integer(name) if row.has(name) else None for name in ("sync_index", "frame_index"))
    time = row.nanoseconds("frame_time", "s") if row.has("frame_time") else None
    return RecordedPicture(row.line, moment, number, time)


def _in_order(path: Path, pictures: Sequence[RecordedPicture]) -> list[RecordedPicture]:
    """Sorted by number, time or moment. Raises InputError where two columns contradict each other."""
    names = ("number", "time", "moment")
    columns = {"number": "frame_index", "time": "frame_time", "moment": "sync_index"}
    known = [name for name in names if getattr(pictures[0], name) is not None]
    ordered = sorted(pictures, key=lambda one: getattr(one, known[0]))
    for before, now in pairwise(ordered):
        for name in known:
            if getattr(now, name) <= getattr(before, name):
                text = f"{columns[name]} does not rise from line {before.line} to this row of the camera"
                remedy = f"one row for each picture, in the order of {columns[known[0]]}"
                raise InputError([Mistake(Place(str(path), now.line, 1), text, remedy)])
    return ordered
