"""The readings of one inertial sensor in a CSV file."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import islice
from typing import Literal

import numpy as np

from followspot import Array, Field, InputPath
from followspot.csv_rows import Row, header_of, read_rows
from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.frame_times import capture_time, exact_rate, to_ns, to_seconds
from followspot_imu.units import FORCE, MAGNETIC, MOST, TURN, VALUES, UnitParams

COLUMNS = (*VALUES, "time", "sensor")


class FileParams(UnitParams):
    """The file, its times, units and axes."""

    path: InputPath = Field(description="the CSV file")
    columns: dict[str, str] = Field(
        {}, description="columns that have another name in the file, for example {gx: gyro_x, time: t}"
    )
    rate: float | None = Field(
        None, ge=0.01, le=1e6, unit="1/s", description="readings a second; needed without a column time"
    )
    time_unit: Literal["s", "ms", "us", "ns"] = Field("s", description="unit of the column time")
    start_time: float = Field(
        0.0, ge=-4e9, le=4e9, unit="s", description="capture time of time 0 in the file, or of its first row"
    )


def read_readings(
    given: FileParams, sensor: str | None, sensors: Collection[str], most_rows: int | None = None
) -> tuple[Array, Array]:
    """Times (N,) ns and values (N, 9), in the file's units and in the order of `VALUES`.

    sensor: whose rows are kept; sensors: of the room, among which a column sensor names the one that a row
    is of; most_rows: that are read, None for all. Raises InputError with file, line and remedy.
    """
    _check_head(given)
    most = (MOST / np.abs(given.scale)).tolist()
    times: list[int] = []
    values: list[list[float]] = []
    rows = read_rows(given.path, (*TURN, *FORCE), (*MAGNETIC, "time", "sensor"), given.columns)
    for row in islice(rows, most_rows):
        if row.has("sensor") and row.known("sensor", sensors, "sensors of the room") != sensor:
            continue
        times.append(_time(row, given, len(times)))
        if len(times) > 1 and times[-1] <= times[-2]:
            raise _not_rising(row, times[-1], times[-2])
        values.append(list(_values(row, most)))
    return np.array(times, "i8"), np.array(values, "f8").reshape(-1, len(VALUES))


def _not_rising(row: Row, time: int, before: int) -> InputError:
    """The mistake of a row whose time is not later than that of the row before it. Times: ns."""
    text = f"time {to_seconds(time):.15g} s comes after {to_seconds(before):.15g} s"
    remedy = "sort the rows of a sensor by time"
    if time == before:
        text = f"time {to_seconds(time):.15g} s comes twice"
        remedy = (
            "remove one of the rows; if times have too few digits, give their column another name and say "
            "the rate, for example with: {rate: 100}"
        )
    return InputError([Mistake(Place(row.file, row.line, 1), text, remedy)])


def _check_head(given: FileParams) -> None:
    """Raises InputError if a column is renamed that there is not, or times are missing."""
    strange = next((name for name in given.columns if name not in COLUMNS), None)
    if strange is not None:
        raise InputError.of(
            f'columns: there is no column "{strange}"', did_you_mean(strange, COLUMNS, "columns")
        )
    head = header_of(given.path)
    if given.columns.get("time", "time") not in head and given.rate is None:
        text = f"{given.path} has no column time"
        raise InputError(
            [Mistake(Place(str(given.path), 1, 1), text, "say the rate, for example with: {rate: 100}")]
        )


def _time(row: Row, given: FileParams, number: int) -> int:
    """Capture time of a row, ns. number: of the sensor's row, from 0."""
    start = to_ns(given.start_time)
    if row.has("time"):
        return start + row.nanoseconds("time", given.time_unit)
    assert given.rate is not None  # the head was checked
    return start + capture_time(number, exact_rate(given.rate))


def _values(row: Row, most: list[float]) -> Iterator[float]:
    """The values of a row; NaN for a magnetometer that the file has not, or that did not read."""
    for name, limit in zip(VALUES, most, strict=True):
        if name in MAGNETIC and not (row.has(name) and row.cell(name)):
            yield np.nan
            continue
        value = row.number(name)
        if abs(value) > limit:
            raise row.mistake(name, f"a number within {limit:g}; check the units")
        yield value
