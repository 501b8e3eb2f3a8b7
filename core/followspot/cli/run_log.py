"""The log of a run: a file gets all records, standard error gets warnings and errors (or all records)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from followspot.log.file import LogFile
from followspot.log.record import LogRecord

_MOST = 50
"""Most kinds of lines on standard error; the file has all records."""
_EVENTS = 20
"""Most lines of one kind about a host or a worker, which may fail and return more than once."""
_NUMBER = re.compile(r"\d+")


class ShownLog:
    """Writes each record to the output folder; shows warnings and errors, similar ones of a stage once.

    Records about a host, a worker or the run itself are shown each time, also those that a fault is over: the
    last line about a host must tell its present state.

    say: shows a line; verbose: whether to show every record.
    """

    def __init__(self, out: Path, say: Callable[[str], None], *, verbose: bool = False) -> None:
        self._file = LogFile(out)
        self._say = say
        self._verbose = verbose
        self._shown: Counter[tuple[str, ...]] = Counter()

    def take(self, record: LogRecord) -> None:
        """Take a record. Threads must not call this at the same time."""
        self._file.write(record)
        if self._verbose:
            self._say(f"followspot: {line_of(record)}")
            return
        kind = (record.host, record.worker, record.stage, _NUMBER.sub("#", record.text))
        event = not record.stage
        if (record.level == "info" and not event) or (kind not in self._shown and len(self._shown) >= _MOST):
            return
        self._shown[kind] += 1
        if self._shown[kind] <= (_EVENTS if event else 1):
            last = event and self._shown[kind] == _EVENTS
            self._say(
                f"followspot: {line_of(record)}" + (f"; more like it: {self._file.path}" if last else "")
            )
            if self._shown[kind] == 1 and len(self._shown) == _MOST:
                self._say(f"followspot: for further warnings see followspot logs, or {self._file.path}")


def line_of(record: LogRecord) -> str:
    """Level, stage, host and the first line of the text."""
    whose = f"{record.stage}: " if record.stage else ""
    lines = record.text.strip().splitlines() or [""]
    return f"{record.level}: {whose}{lines[0]}" + (f" [{record.host}]" if record.host else "")
