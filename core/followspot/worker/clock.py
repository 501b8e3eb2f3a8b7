"""Offsets from this host's clocks to the run's reference clock."""

from __future__ import annotations

import time
from typing import NamedTuple

from followspot.operating_system.wall_clock import lead, set_since

_NEAR = 10_000_000_000
"""ns: a capture time this close to the host's clock was read from it, and not from a recording."""


class Arrival(NamedTuple):
    """When a message came. wall: by the wall clock of this host, ns; offset: to the run's time then, ns;
    step: by how much the wall clock was set since the run began, ns.
    """

    wall: int
    offset: int
    step: int = 0

    def is_near(self, time: int) -> bool:
        """Whether a capture time, ns, can have been read from this host's clock, as it is or was at first."""
        return min(abs(time - self.wall), abs(time - self.wall + self.step)) < _NEAR


class Clock:
    """Clock offsets of one host, which the operator sets while the graph runs, and when the run began.

    steady: ns to add to the monotonic clock, which measures latency and deadlines; begun: when the stages of
    this host began, ns of its monotonic clock, 0 before.
    """

    __slots__ = ("_captured", "begun", "steady")

    def __init__(self, captured: int = 0, steady: int = 0, before: int | None = None) -> None:
        """See `correct`; before: None for the lead that it has now."""
        self.correct(captured, steady, lead() if before is None else before)
        self.begun = 0

    def correct(self, captured: int, steady: int, before: int) -> None:
        """Take new offsets. captured: ns to add to capture times of live sources, which the wall clock gives,
        while its lead over the monotonic clock is `before`, ns; if it is set, the run's times go on.
        """
        self._captured = captured, before
        self.steady = steady

    def run_begun(self) -> int:
        """When the stages of this host began, ns of its monotonic clock: now, if they have not yet."""
        return self.begun or time.monotonic_ns()

    def now(self) -> int:
        """The reference host's monotonic clock, ns."""
        return time.monotonic_ns() + self.steady

    def arrival(self) -> Arrival:
        """The present moment for a message that has just come. Safe from any thread."""
        captured, before = self._captured
        step = set_since(before)
        return Arrival(time.time_ns(), captured - step, step)

    def capture_time(self, given: int, came: Arrival | None = None) -> int:
        """A live source's capture time `given`, ns, on the reference clock; recorded times stay the same.

        came: when the message came, now if None.
        """
        came = came or self.arrival()
        if abs(given - came.wall) < _NEAR:
            return given + came.offset
        return given + came.offset + came.step if came.is_near(given) else given
