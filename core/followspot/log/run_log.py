"""The newest log records of a run, which each host keeps, and the operator."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from itertools import islice
from threading import Lock

from followspot.log.record import MAX_TEXT, PAGE, Level, LogPage, LogRecord

KEPT = 2000
"""Most records kept."""

OnLog = Callable[[LogRecord], None]
"""Called with every record, in order of arrival."""


class RunLog:
    """Records, numbered from 0 in order of arrival. Safe from any thread. on_log: called with each."""

    def __init__(self, on_log: OnLog | None = None) -> None:
        self.on_log = on_log
        self.last = -1
        """Number of the newest record; -1 before the first."""
        self._kept: deque[LogRecord] = deque(maxlen=KEPT)
        self._guard = Lock()

    def add(self, *records: LogRecord) -> None:
        """Append records."""
        with self._guard:
            for record in records:
                self._kept.append(record)
                self.last += 1
                if self.on_log is not None:
                    self.on_log(record)

    def say(self, level: Level, text: str, *, worker: str = "") -> None:
        """Append a record with the present time."""
        self.add(LogRecord(time.time_ns(), level, text[:MAX_TEXT], worker=worker))

    def after(self, number: int) -> LogPage:
        """Records after the one of this number, the oldest first, as many as fit on a page."""
        with self._guard:
            first = self.last + 1 - len(self._kept)
            start = max(0, number + 1 - first)
            found = tuple(islice(self._kept, start, start + PAGE))
            return LogPage(found, first + start + len(found) - 1)
