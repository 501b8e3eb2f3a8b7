"""The results of a sweep as a table: text, CSV, Parquet."""

from __future__ import annotations

import csv
import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from followspot.errors import writing
from followspot.tables.terminal import table
from followspot_sweep.axes import Axis
from followspot_sweep.trial import Result

CSV, PARQUET = "sweep.csv", "sweep.parquet"
SHOWN = ("coverage", "rmse_mm", "median_mm", "p95_mm", "identity_switches", "false_share", "recovery_worst")
NO_PARQUET = 'no Parquet file: pyarrow is not installed; pip install "followspot[parquet]"'


def rows(results: Sequence[Result]) -> list[dict[str, Any]]:
    """A row for each result: room, parameters, figures, error; a number if the value is one."""
    figures = dict.fromkeys(key for result in results for key in result.figures)
    return [
        {
            "room": result.task.room,
            **{name: _plain(value) for name, value in result.task.point},
            **{key: result.figures.get(key) for key in figures},
            "error": result.error,
        }
        for result in results
    ]


def best(found: Sequence[dict[str, Any]], figure: str) -> dict[str, Any] | None:
    """The row with the smallest figure; None if no row has it."""
    known = [row for row in found if row.get(figure) is not None]
    return min(known, key=lambda row: float(row[figure]), default=None)


def text(found: Sequence[dict[str, Any]], axes: Sequence[Axis], figure: str) -> str:
    """The varied parameters and the main figures; the best row has a star."""
    varied = [axis.name for axis in axes if len(axis.values) > 1]
    shown = [key for key in dict.fromkeys((*SHOWN, figure)) if any(row.get(key) is not None for row in found)]
    winner = best(found, figure)
    lines = []
    for row in found:
        cells = [str(row[name]) for name in varied] + [_cell(row.get(key)) for key in shown]
        mark = "*" if row is winner else "failed" if row["error"] else ""
        lines.append((str(row["room"]), *cells, mark))
    return table(("room", *varied, *shown, ""), lines)


def write(found: Sequence[dict[str, Any]], folder: Path) -> str:
    """Write the files; return a line that names them and what is missing. Raises FollowspotError."""
    with writing(folder / CSV), (folder / CSV).open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(found[0]))
        writer.writeheader()
        writer.writerows(found)
    if importlib.util.find_spec("pyarrow") is None:
        return f"table: {folder / CSV}\n{NO_PARQUET}"
    import pyarrow as pa
    from pyarrow.parquet import write_table

    columns = {key: _alike([row[key] for row in found]) for key in found[0]}
    with writing(folder / PARQUET):
        write_table(pa.table(columns), folder / PARQUET)
    return f"tables: {folder / CSV}, {folder / PARQUET}"


def _alike(values: list[Any]) -> list[Any]:
    """The values in one type: all texts if any is a text."""
    return [str(v) for v in values] if any(isinstance(v, str) for v in values) else values


def _plain(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
