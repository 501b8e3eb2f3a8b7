"""The log of a run while it goes on: all of it in a file, and what is wrong on standard error."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from followspot.log.file import LogFile
from followspot.log.record import LogRecord

_MOST = 50
"""Lines shown; the file has the others."""
_NUMBER = re.compile(r"\d+")


class ShownLog:
    """Writes each record to the output folder; shows warnings and errors, those that are alike once.

    say: shows a line.
    """

    def __init__(self, out: Path, say: Callable[[str], None]) -> None:
        self._file = LogFile(out)
        self._say = say
        self._shown: set[tuple[str, str, str]] = set()

    def take(self, record: LogRecord) -> None:
        """A record, from any thread but from one at a time."""
        self._file.write(record)
        if record.level == "info" or len(self._shown) >= _MOST:
            return
        kind = (record.worker, record.stage, _NUMBER.sub("#", record.text))
        if kind not in self._shown:
            self._shown.add(kind)
            self._say(f"followspot: {line_of(record)}")
            if len(self._shown) == _MOST:
                self._say(f"followspot: further ones: followspot logs, or {self._file.path}")


def line_of(record: LogRecord) -> str:
    """Level, stage, place and the first line of what was said."""
    whose = f"{record.stage}: " if record.stage else ""
    lines = record.text.strip().splitlines() or [""]
    return f"{record.level}: {whose}{lines[0]}" + (f" [{record.host}]" if record.host else "")
