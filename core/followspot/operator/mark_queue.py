"""Marks: moments of a run that its flight recorder saves, and the state of the recorder."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock
from typing import Literal

from followspot.control.dispatch import NoAnswer
from followspot.errors import FollowspotError
from followspot.log.record import Level
from followspot.valid_values.numbers import Count, Figure

_SILENT = 10.0
"""Seconds without a report after which a flight recorder counts as gone."""
_MOST_WAITING = 100
"""Marks that may wait for the flight recorder."""


@dataclass(frozen=True)
class Mark:
    """A moment to save. after: s that belong to it after now; note: a text of the user."""

    number: Count
    after: Figure
    note: str = ""


@dataclass(frozen=True)
class Moment:
    """A file of one mark, or of several whose times overlap.

    marks: numbers of the marks that users made; notes: of all marks, also of those by conditions and faults;
    state: open while messages after the mark belong to it; seconds: from its first to its last capture time;
    lost: messages that are missing; problem: why it failed, "" if it did not.
    """

    file: str
    marks: tuple[Count, ...]
    notes: tuple[str, ...]
    state: Literal["open", "complete", "failed"]
    seconds: Figure = 0.0
    messages: Count = 0
    lost: Count = 0
    bytes: Count = 0
    problem: str = ""


@dataclass(frozen=True)
class RecorderState:
    """The state of a flight recorder.

    seconds: that it is to hold; ports: number of ports; held: seconds that it holds of the port of which it
    holds the least; bytes, limit: of the messages in memory, and the most it may hold; lost: messages that
    never came; moments: the newest files, the newest last.
    """

    seconds: Figure
    ports: Count
    held: Figure
    bytes: Count
    limit: Count
    messages: Count
    lost: Count
    moments: tuple[Moment, ...] = ()


class MarkQueue:
    """Hands marks to the flight recorder of a run. Safe from any thread.

    say: writes to the run's log; monotonic: a clock, s.
    """

    def __init__(
        self, say: Callable[[Level, str], None], monotonic: Callable[[], float] = time.monotonic
    ) -> None:
        self._say = say
        self._clock = monotonic
        self._guard = Lock()
        self._waiting: list[Mark] = []
        self._newest = 0
        self._kept: RecorderState | None = None
        self._over = False
        """Whether the flight recorder has ended before the run."""
        self._reported_at = 0.0
        self._logged: dict[str, str] = {}
        """The last state of each file that the log has."""

    def mark(self, after: float, note: str) -> int:
        """Number of a new mark. Raises FollowspotError if the run has no flight recorder, or a silent one."""
        with self._guard:
            if self._over:
                raise NoAnswer("the flight recorder of this run has ended; nothing of the run is kept")
            if self._kept is None:
                raise FollowspotError("nothing of this run is kept; start it with --keep 30s")
            if self._clock() - self._reported_at > _SILENT or len(self._waiting) >= _MOST_WAITING:
                raise NoAnswer("the flight recorder of this run does not answer")
            self._newest += 1
            self._waiting.append(Mark(self._newest, after, note))
            return self._newest

    def exchange(self, kept: RecorderState | None, taken: int) -> tuple[Mark, ...]:
        """Take the state of the flight recorder, None if it has ended; the marks after the number `taken`."""
        if kept is None:
            self._kept, self._over = None, True
            return ()
        with self._guard:
            self._kept, self._reported_at = kept, self._clock()
            self._waiting = [mark for mark in self._waiting if mark.number > taken]
            waiting = tuple(self._waiting)
        for moment in kept.moments:
            if self._logged.get(moment.file) != moment.state:
                self._logged[moment.file] = moment.state
                self._say("warning" if moment.state == "failed" else "info", _line(moment))
        return waiting

    @property
    def kept(self) -> RecorderState | None:
        """The newest state that the flight recorder reported; None before the first."""
        return self._kept


def _line(moment: Moment) -> str:
    notes = "; ".join(filter(None, moment.notes))
    why = f" ({notes})" if notes else ""
    if moment.state == "failed":
        return f"a marked moment is not saved{why}: {moment.problem}"
    if moment.state == "open":
        return f"a moment is marked{why}: {moment.file}"
    size = f"{moment.seconds:.1f} s, {moment.messages} messages, {moment.bytes / 1e6:.1f} MB"
    return f"the marked moment is saved{why}: {moment.file}, {size}, {moment.lost} missing"
