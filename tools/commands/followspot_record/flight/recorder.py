"""Keeps the last seconds of a run, and writes those around a mark into a file."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from followspot.library.handle import Moment, RecorderState
from followspot.ports.firing import is_firings
from followspot_record.flight.kept_messages import KeptMessages
from followspot_record.flight.moment_file import MomentFile
from followspot_record.flight.moment_span import MomentSpan

_MOST_TOLD = 50
"""Files that are reported to the run."""


class FlightRecorder:
    """Marks whose times overlap share a file. Safe from any thread.

    period: seconds that are kept; limit: bytes of the messages in memory; open_file: begins a new file;
    monotonic: a clock, s.
    """

    def __init__(
        self,
        period: float,
        limit: int,
        open_file: Callable[[], MomentFile],
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._period = period
        self._limit = limit
        self._open_file = open_file
        self._clock = monotonic
        self._guard = threading.Lock()
        self._held = KeptMessages(period, limit)
        self._lost = 0
        self._file: MomentFile | None = None
        self._span = MomentSpan()
        self._open = False
        """Whether messages still belong to the present file."""
        self._ended = 0.0
        """When they ceased to, s."""
        self._past: list[Moment] = []

    def put(self, port: str, capture_time: int, missing: int, packed: bytes) -> None:
        """Take a message. missing: messages of its port that never came, just before it."""
        with self._guard:
            self._lost += missing
            message = self._held.put(port, capture_time, missing, packed)
            if self._open and self._file is not None and self._span.takes(message):
                self._file.put(message, held=False)

    def mark(self, after: float, note: str, number: int = 0) -> None:
        """Save what is held, and the seconds to come. number: of a user's mark.

        Raises FollowspotError if no file can be begun.
        """
        with self._guard:
            if self._file is not None and (self._file.failed or self._file.gone):
                self._leave()
            if self._file is None:
                self._file, self._span = self._open_file(), MomentSpan()
            for message in self._span.extend(self._held, after, self._clock()):
                self._file.put(message, held=True)
            newest = max(map(self._held.newest, self._held.ports), default=0)
            self._file.mark(number, note, newest)
            self._open = True

    def refuse(self, note: str, problem: str) -> None:
        """Tell once that a moment is not saved, and why."""
        with self._guard:
            if not any(moment.problem == problem for moment in self._past):
                self._past.append(Moment("", (), (note,), "failed", problem=problem))

    def finish_files(self) -> None:
        """Complete a file to which nothing more belongs; leave it when no later mark can overlap with it."""
        with self._guard:
            if self._file is None:
                return
            now = self._clock()
            if self._open and self._span.over(self._held, now):
                self._open, self._ended = False, now
                self._file.complete()
            if self._file.failed or not (self._open or now - self._ended < self._period):
                self._leave()

    def close(self) -> None:
        """Complete the file, if there is one."""
        with self._guard:
            if self._file is not None:
                self._leave()

    def kept(self) -> RecorderState:
        """The messages that are held, in numbers, and the files."""
        with self._guard:
            held = self._held
            present = [] if self._file is None else [self._file.moment]
            return RecorderState(
                self._period,
                sum(not is_firings(port) for port in held.ports),
                held.held(),
                held.bytes,
                self._limit,
                held.messages,
                self._lost,
                (*self._past, *present)[-_MOST_TOLD:],
            )

    def _leave(self) -> None:
        assert self._file is not None
        self._file.close()
        self._past = [*self._past, self._file.moment][-_MOST_TOLD:]
        self._file, self._open = None, False
