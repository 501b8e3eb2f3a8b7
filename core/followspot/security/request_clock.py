"""The time that a request says, although the clock of the sender is set while a run goes on."""

from __future__ import annotations

import time
from collections.abc import Callable

_LEAST = 1.0
"""Smallest change of the wall clock that counts as set, s."""


class RequestClock:
    """The wall clock as it was at the first request to an agent, s: an operator whose clock is set meanwhile
    still agrees with the agent.

    clock: wall-clock time, s; steady: a monotonic clock, s.
    """

    def __init__(
        self, clock: Callable[[], float] = time.time, steady: Callable[[], float] = time.monotonic
    ) -> None:
        self._clock = clock
        self._steady = steady
        self._lead = self._difference()

    def now(self) -> float:
        """The time of a request that is sent now."""
        return self._steady() + self._lead

    def other(self) -> RequestClock | None:
        """The clock that goes by the wall clock as it is now; None if it was not set since."""
        if abs(self._difference() - self._lead) < _LEAST:
            return None
        return RequestClock(self._clock, self._steady)

    def _difference(self) -> float:
        return self._clock() - self._steady()
