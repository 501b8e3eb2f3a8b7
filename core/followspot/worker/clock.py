"""What must be added to this host's clocks so that they read like those of the host that all go by."""

from __future__ import annotations

import time

_NEAR = 10_000_000_000
"""ns from the clock of the host within which a capture time was read from it, and not from a recording."""


class Clock:
    """Corrections of one host; the deploying side sets them while the graph runs.

    captured: of capture times of live sources, ns, on the clock that knows the date; steady: of the monotonic
    clock, by which latency and deadlines are measured, ns.
    """

    __slots__ = ("captured", "steady")

    def __init__(self, captured: int = 0, steady: int = 0) -> None:
        self.captured = captured
        self.steady = steady

    def now(self) -> int:
        """The monotonic clock of all, ns."""
        return time.monotonic_ns() + self.steady

    def capture_time(self, given: int) -> int:
        """When a live source captured what it says to have captured at `given`, by the clock of all, ns."""
        if self.captured and abs(given - time.time_ns()) < _NEAR:
            return given + self.captured
        return given
