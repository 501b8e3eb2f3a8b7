"""Offsets from this host's clocks to the run's reference clock."""

from __future__ import annotations

import time

_NEAR = 10_000_000_000
"""ns: a capture time this close to the host's clock was read from it, and not from a recording."""


class Clock:
    """Clock offsets of one host, which the operator sets while the graph runs, and when the run began.

    captured: ns to add to capture times of live sources, which the wall clock gives; steady: ns to add to the
    monotonic clock, which measures latency and deadlines; begun: when the stages of this host began, ns
    of its monotonic clock, 0 before.
    """

    __slots__ = ("begun", "captured", "steady")

    def __init__(self, captured: int = 0, steady: int = 0) -> None:
        self.captured = captured
        self.steady = steady
        self.begun = 0

    def run_begun(self) -> int:
        """When the stages of this host began, ns of its monotonic clock: now, if they have not yet."""
        return self.begun or time.monotonic_ns()

    def now(self) -> int:
        """The reference host's monotonic clock, ns."""
        return time.monotonic_ns() + self.steady

    def capture_time(self, given: int) -> int:
        """A live source's capture time `given`, ns, on the reference clock; recorded times stay the same."""
        if self.captured and abs(given - time.time_ns()) < _NEAR:
            return given + self.captured
        return given
