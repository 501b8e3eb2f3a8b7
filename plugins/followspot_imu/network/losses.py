"""Readings that are missing, by the device times of those that came."""

from __future__ import annotations

from collections import deque

import numpy as np

KNOWN = 200
"""Intervals that say how often a sensor reads, a tenth of them at least."""


class Losses:
    """rate: readings a second, None if it is not known: then the usual interval says it."""

    def __init__(self, rate: float | None) -> None:
        self._interval = 1e9 / rate if rate else 0.0
        self._intervals: deque[int] | None = None if rate else deque(maxlen=KNOWN)

    def within(self, interval: int) -> int:
        """Number of readings that are missing within an interval of two that came, ns; 0: not known."""
        if self._intervals is not None and interval:
            self._intervals.append(interval)
            if len(self._intervals) >= KNOWN // 10:
                self._interval = float(np.median(self._intervals))
        return max(0, round(interval / self._interval) - 1) if self._interval else 0
