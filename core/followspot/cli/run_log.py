"""The log of a run: all records go to a file, warnings and errors also to standard error, or all."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from followspot.log.file import LogFile
from followspot.log.record import LogRecord

_MOST = 50
"""Lines on standard error at most; the file has all records."""
_NUMBER = re.compile(r"\d+")


class ShownLog:
    """Writes each record to the output folder; shows warnings and errors, similar ones once.

    say: shows a line; verbose: whether to show every record.
    """

    def __init__(self, out: Path, say: Callable[[str], None], *, verbose: bool = False) -> None:
        self._file = LogFile(out)
        self._say = say
        self._verbose = verbose
        self._shown: set[tuple[str, str, str]] = set()

    def take(self, record: LogRecord) -> None:
        """Take a record. Threads must not call this at the same time."""
        self._file.write(record)
        if self._verbose:
            self._say(f"followspot: {line_of(record)}")
            return
        if record.level == "info" or len(self._shown) >= _MOST:
            return
        kind = (record.worker, record.stage, _NUMBER.sub("#", record.text))
        if kind not in self._shown:
            self._shown.add(kind)
            self._say(f"followspot: {line_of(record)}")
            if len(self._shown) == _MOST:
                self._say(f"followspot: for further warnings see followspot logs, or {self._file.path}")


def line_of(record: LogRecord) -> str:
    """Level, stage, host and the first line of the text."""
    whose = f"{record.stage}: " if record.stage else ""
    lines = record.text.strip().splitlines() or [""]
    return f"{record.level}: {whose}{lines[0]}" + (f" [{record.host}]" if record.host else "")
