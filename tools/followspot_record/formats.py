"""The formats of `followspot export`: each writes the messages of one port into one file."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from followspot.messages import Message
from followspot_record.rows import as_json, headings, rows

Write = Callable[[Path, type[Message], Iterator[Message]], int]


@dataclass(frozen=True)
class Format:
    """write: returns how many rows it wrote; needs: the package that it needs besides."""

    write: Write
    needs: str = ""


def write_csv(path: Path, kind: type[Message], messages: Iterator[Message]) -> int:
    """A line for each row of each message."""
    count = 0
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(headings(kind))
        for message in messages:
            for row in rows(message):
                writer.writerow(row)
                count += 1
    return count


def write_jsonl(path: Path, kind: type[Message], messages: Iterator[Message]) -> int:
    """A line for each message."""
    count = 0
    with path.open("w", encoding="utf-8") as file:
        for message in messages:
            file.write(json.dumps(as_json(message), allow_nan=False, separators=(",", ":")) + "\n")
            count += 1
    return count


FORMATS: Mapping[str, Format] = {"csv": Format(write_csv), "jsonl": Format(write_jsonl)}
