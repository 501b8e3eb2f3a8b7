"""Collects log records of a worker's stages and libraries, at a bounded rate, until the host takes them."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock

from followspot.errors import printable_lines
from followspot.log.record import MAX_TEXT, Level, LogRecord
from followspot.stage import LOGGER

PER_SECOND = 50.0
"""Records kept in the long run, 1/s."""
BURST = 500
"""Records kept at once; further ones are only counted."""


class LogCollector(logging.Handler):
    """Takes Python's log records and the warnings of stages. Safe from any thread.

    worker: its name; monotonic: a clock, s.
    """

    def __init__(self, worker: str, monotonic: Callable[[], float] = time.monotonic) -> None:
        super().__init__(logging.INFO)
        self.worker = worker
        self._monotonic = monotonic
        self._guard = Lock()
        self._waiting: list[LogRecord] = []
        self._left_out = 0
        self._allowed, self._at = float(BURST), monotonic()

    def say(self, level: Level, stage: str, text: str) -> None:
        """Take a record, or only count it if too many came."""
        with self._guard:
            now = self._monotonic()
            self._allowed = min(BURST, self._allowed + (now - self._at) * PER_SECOND)
            self._at = now
            if self._allowed < 1.0:
                self._left_out += 1
                return
            self._allowed -= 1.0
            self._waiting.append(self._record(level, stage, text))

    def emit(self, record: logging.LogRecord) -> None:
        """Take one of Python's log records."""
        try:
            text = record.getMessage()
            if record.exc_info:
                text += "\n" + logging.Formatter().formatException(record.exc_info)
        except Exception as error:
            text = f"{record.msg!r} cannot be formatted: {error}"
        self.say(_level(record.levelno), record.name.removeprefix(f"{LOGGER}."), text)

    def take(self) -> list[LogRecord]:
        """Records since the last call."""
        with self._guard:
            taken, self._waiting = self._waiting, []
            left_out, self._left_out = self._left_out, 0
        if left_out:
            taken.append(self._record("warning", "", f"{left_out} more records were left out"))
        return taken

    def _record(self, level: Level, stage: str, text: str) -> LogRecord:
        text = printable_lines(text)[:MAX_TEXT]
        return LogRecord(time.time_ns(), level, text, worker=self.worker, stage=stage[:200])


@contextmanager
def collecting(collector: LogCollector) -> Iterator[None]:
    """Within the block, log records of this process go to the collector, from level info on."""
    root = logging.getLogger()
    before = root.level
    root.addHandler(collector)
    root.setLevel(min(before, logging.INFO))
    try:
        yield
    finally:
        root.setLevel(before)
        root.removeHandler(collector)


def _level(number: int) -> Level:
    if number >= logging.ERROR:
        return "error"
    return "warning" if number >= logging.WARNING else "info"
