"""The formats of `followspot export`: each writes the messages of one port into one file."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from followspot import Context, Room
from followspot.messages import Message
from followspot_record.recorded_rows import TEXT, headings, rows
from followspot_sinks.json_lines import json_text
from followspot_sinks.rerun.viewer import Rerun

_GROUP = 1 << 14


@dataclass(frozen=True)
class Port:
    """A port to write. name: STAGE.PORT; room: of the recorded run."""

    name: str
    kind: type[Message]
    messages: Iterator[Message]
    room: Room


Write = Callable[[Path, Port], int]


@dataclass(frozen=True)
class Format:
    """write: returns how many rows it wrote; needs: the package that it needs besides."""

    write: Write
    suffix: str
    needs: str = ""
    pictures: bool = False
    """True if pictures are written by default."""


def write_csv(path: Path, port: Port) -> int:
    """A line for each row of each message."""
    count = 0
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(headings(port.kind, port.room))
        for message in port.messages:
            for row in rows(message, port.room):
                writer.writerow(row)
                count += 1
    return count


def write_jsonl(path: Path, port: Port) -> int:
    """A line for each message."""
    count = 0
    with path.open("w", encoding="utf-8") as file:
        for message in port.messages:
            file.write(json_text(message, port.room) + "\n")
            count += 1
    return count


def write_parquet(path: Path, port: Port) -> int:
    """A row for each row of each message, in groups that fit into memory."""
    import pyarrow as pa
    from pyarrow.parquet import ParquetWriter

    codes = headings(port.kind, port.room)
    schema = pa.schema(
        [(name, pa.string() if code == TEXT else pa.from_numpy_dtype(code)) for name, code in codes.items()]
    )
    count = 0
    waiting: list[tuple[Any, ...]] = []
    with ParquetWriter(path, schema) as writer:
        for message in chain(port.messages, [None]):
            waiting += () if message is None else rows(message, port.room)
            if waiting and (message is None or len(waiting) >= _GROUP):
                columns = zip(*waiting, strict=True)
                arrays = [pa.array(c, f.type) for c, f in zip(columns, schema, strict=True)]
                writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
                count += len(waiting)
                waiting.clear()
    return count


def write_rerun(path: Path, port: Port) -> int:
    """A file for the Rerun viewer, as the stage sinks.rerun writes it."""
    viewer = Rerun(Context(port.name, port.room, out=path.parent), path=Path(path.name))
    viewer.setup()
    count = 0
    try:
        for message in port.messages:
            viewer.process(message)
            count += 1
    finally:
        viewer.close()
    return count


FORMATS: Mapping[str, Format] = {
    "csv": Format(write_csv, "csv"),
    "jsonl": Format(write_jsonl, "jsonl"),
    "parquet": Format(write_parquet, "parquet", "pyarrow"),
    "rerun": Format(write_rerun, "rrd", "rerun", pictures=True),
}
