"""The rows of a CSV file by frame: their numbers and capture times, in order, and nothing twice."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Generic, Literal, TypeVar

from followspot import Field, InputPath, StageParams
from followspot.csv_rows import Row, header_of, read_rows
from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.frame_times import capture_time, exact_rate, to_ns, to_seconds
from followspot_vision.frame_steps import doubt_of_steps

T = TypeVar("T")
MOST_IN_A_FRAME = 10_000
"""Rows of one frame and camera."""
MOST_FRAMES = 10_000_000
"""From the first frame of a file to the last."""


class FrameParams(StageParams):
    """A file and the times of its frames."""

    path: InputPath = Field(description="the CSV file")
    columns: dict[str, str] = Field(
        {}, description="columns that have another name in the file, for example {x: u, y: v}"
    )
    fps: float | None = Field(
        None,
        ge=0.001,
        le=100_000,
        unit="1/s",
        description="frame rate; needed if the file has no column time",
    )
    time_unit: Literal["s", "ms", "us", "ns"] = Field("s", description="unit of the column time")
    start_time: float = Field(
        0.0, ge=-4e9, le=4e9, unit="s", description="capture time of frame 0, or of time 0 in the file"
    )


@dataclass(frozen=True)
class FrameRows(Generic[T]):
    """The rows of one frame in a file. number: -1 if it does not number frames; time: capture time, ns."""

    number: int
    time: int
    rows: tuple[T, ...]


@dataclass(frozen=True)
class FrameTable(Generic[T]):
    """The frames of one camera, ascending. Frames that only other cameras have are empty.

    own: frames with rows; others: number -> capture time, ns, of frames with rows of any camera; time_of:
    number -> capture time, ns, if times follow from numbers: then every frame from the first to the last is
    there; doubt: why they hardly were all looked at, "" if they may be.
    """

    own: Sequence[FrameRows[T]]
    others: dict[int, int]
    time_of: Callable[[int], int] | None
    doubt: str = ""

    def __len__(self) -> int:
        if self.time_of is not None and self.others:
            return max(self.others) - min(self.others) + 1
        return len(self.others) or len(self.own)

    def __iter__(self) -> Iterator[FrameRows[T]]:
        if not self.others:
            yield from self.own
            return
        own = {frame.number: frame for frame in self.own}
        known = range(min(self.others), max(self.others) + 1) if self.time_of else sorted(self.others)
        for number in known:
            time = self.time_of(number) if self.time_of else self.others[number]
            yield own.get(number) or FrameRows(number, time, ())


def read_frames(
    given: FrameParams,
    columns: Sequence[str],
    optional: Sequence[str],
    read: Callable[[Row], T],
    camera: str | None = None,
    cameras: Collection[str] = (),
    most: int | None = None,
) -> FrameTable[T]:
    """The frames of a file, or of one camera in it.

    columns, optional: beside frame, time and camera; camera: whose rows are kept, of the known cameras; None
    if the file has no column camera; most: rows that are read, None for all. Raises InputError with file,
    line and remedy.
    """
    needs = (*columns, *(() if camera is None else ("camera",)))
    has_frame, has_time = _check_head(given, needs, optional)
    time_of = None if has_time else _times(given)
    start = to_ns(given.start_time)
    own: list[tuple[int, int, list[T]]] = []
    moments: dict[int, int] = {}
    for row in islice(read_rows(given.path, needs, (*optional, "frame", "time"), given.columns), most):
        number = row.integer("frame") if has_frame else -1
        time = time_of(number) if time_of is not None else row.nanoseconds("time", given.time_unit) + start
        if has_frame:
            moments.setdefault(number, time)
        if camera is not None and row.known("camera", cameras, "cameras of the room") != camera:
            continue
        rows = _rows_of_frame(own, row, (number, time))
        rows.append(read(row))
        if len(rows) > MOST_IN_A_FRAME:
            raise _wrong(row, f"more than {MOST_IN_A_FRAME} rows of one frame", "split the file by camera")
    frames = [FrameRows(number, time, tuple(rows)) for number, time, rows in own]
    moments.update({frame.number: frame.time for frame in frames if has_frame})
    _check_moments(given.path, moments)
    doubt = doubt_of_steps(moments, given.fps or 1.0) if time_of is not None else ""
    return FrameTable(frames, moments, time_of, doubt)


def _check_head(given: FrameParams, needs: Sequence[str], optional: Sequence[str]) -> tuple[bool, bool]:
    """Whether the file has the columns frame and time. Raises InputError if it has neither, or no rate, or
    lacks a column that is needed.
    """
    known = (*needs, *optional, "frame", "time")
    strange = next((name for name in given.columns if name not in known), None)
    if strange is not None:
        raise InputError.of(
            f'columns: there is no column "{strange}"', did_you_mean(strange, known, "columns")
        )
    head = header_of(given.path)
    has_frame, has_time = (given.columns.get(name, name) in head for name in ("frame", "time"))
    if not (has_frame or has_time):
        place = Place(str(given.path), 1, 1)
        text = "neither a column frame nor a column time"
        raise InputError([Mistake(place, text, did_you_mean("frame", head, "columns"))])
    if not has_time and given.fps is None:
        text = f"{given.path} numbers frames and has no column time"
        raise InputError.of(text, "add the frame rate of the pictures, for example with: {fps: 30}")
    absent = [name for name in needs if given.columns.get(name, name) not in head]
    if absent:
        wanted = [given.columns.get(name, name) for name in absent]
        text = f"missing columns: {', '.join(wanted)}"
        remedy = f"{did_you_mean(wanted[0], head, 'columns')}; say it with columns: {{{absent[0]}: NAME}}"
        raise InputError([Mistake(Place(str(given.path), 1, 1), text, remedy)])
    return has_frame, has_time


def _times(given: FrameParams) -> Callable[[int], int]:
    """Capture times, ns, of frames by number."""
    rate, start = exact_rate(given.fps or 1.0), to_ns(given.start_time)
    return lru_cache(maxsize=16)(lambda number: start + capture_time(number, rate))


def _rows_of_frame(own: list[tuple[int, int, list[T]]], row: Row, now: tuple[int, int]) -> list[T]:
    """The rows read so far of the frame that this row belongs to: the last one, or a new one.

    own: number, capture time, ns, and rows of each frame; now: number and time of the row. Raises InputError.
    """
    last = own[-1][:2] if own else None
    if last != now:
        _check_order(row, last, now)
        own.append((*now, []))
    return own[-1][2]


def _check_order(row: Row, last: tuple[int, int] | None, now: tuple[int, int]) -> None:
    """Raises InputError unless number and time both rise."""
    if last is None or (now[1] > last[1] and (now[0] > last[0] or now[0] < 0)):
        return
    by_time = now[0] < 0 or now[0] > last[0]
    name, value = ("time", f"{to_seconds(now[1]):g} s") if by_time else ("frame", now[0])
    before = f"{to_seconds(last[1]):g} s" if by_time else last[0]
    if now[0] == last[0] >= 0:
        raise _wrong(row, f"frame {now[0]} has two times", "give all rows of a frame and camera one time")
    raise _wrong(
        row, f"{name} {value} comes after {before}", "sort the rows of each camera by frame and time"
    )


def _check_moments(path: Path, moments: dict[int, int]) -> None:
    """Raises InputError if numbers lie too far apart or times do not rise with them, over all cameras."""
    if moments and max(moments) - min(moments) >= MOST_FRAMES:
        text = f"{path} goes from frame {min(moments)} to {max(moments)}"
        raise InputError.of(text, f"at most {MOST_FRAMES} frames; number them from 0")
    last = None
    for number in sorted(moments):
        if last is not None and moments[number] <= moments[last]:
            text = f"{path}: frame {number} is not later than frame {last}"
            raise InputError.of(text, "number the frames of all cameras alike, or leave out the column frame")
        last = number


def _wrong(row: Row, text: str, remedy: str) -> InputError:
    return InputError([Mistake(Place(row.file, row.line, 1), text, remedy)])
