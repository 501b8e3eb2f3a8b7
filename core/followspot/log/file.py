"""The log file in the output folder of a run: a JSON object a line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from followspot.errors import InputError, Mistake
from followspot.files import RUN_LOG, open_text
from followspot.log.record import LogRecord, records_from_data

MAX_BYTES = 64 << 20
"""Largest file, bytes; further records are not written."""


class LogFile:
    """Writes records to a file, which it creates with the first record, and ends when the disk is full.

    again: whether the run of this folder goes on; else an older log there is deleted.
    """

    def __init__(self, folder: Path, *, again: bool = False) -> None:
        self.path = folder / RUN_LOG
        self._left = MAX_BYTES
        with suppress(OSError):
            if again:
                self._left -= self.path.stat().st_size
            else:
                self.path.unlink()

    def write(self, record: LogRecord) -> None:
        """Append a record; the system has it when this returns."""
        line = (json.dumps(record.to_data()) + "\n").encode()
        if len(line) > self._left:
            return
        self._left -= len(line)
        try:
            with self.path.open("ab", buffering=0) as file:
                if (written := file.write(line)) < len(line):  # so much room was left on the disk
                    self._left = 0
                    file.truncate(file.tell() - written)
        except OSError:
            self._left = 0


def read_log(folder: Path) -> Iterator[LogRecord]:
    """The records in a run's output folder. Raises InputError if there is no log, or a line is no record."""
    path = folder / RUN_LOG
    try:
        with open_text(path, errors="replace") as file:
            for number, line in enumerate(iter(lambda: file.readline(MAX_BYTES), ""), 1):
                if line.endswith("\n"):  # else it is not written completely, or never will be
                    yield _record(path, number, line)
    except OSError as error:
        remedy = "name the output folder of a run, or a run that goes on"
        raise InputError([Mistake(None, f"cannot read {path}: {error.strerror}", remedy)]) from None


def _record(path: Path, number: int, line: str) -> LogRecord:
    try:
        (record,) = records_from_data([json.loads(line)])
    except (ValueError, RecursionError):
        remedy = "it was not written by followspot, or damaged since; the lines before it are good"
        raise InputError([Mistake(None, f"{path}:{number}: not a record of a log", remedy)]) from None
    return record
