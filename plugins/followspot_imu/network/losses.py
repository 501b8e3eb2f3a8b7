"""Counts missing readings, from the device times of those that came."""

from __future__ import annotations

from collections import deque

import numpy as np

KNOWN = 200
"""Intervals whose median is that of the sensor, if its rate is not known; a tenth of them is enough."""


class Losses:
    """Counts missing readings. rate: readings a second, None to take the median interval."""

    def __init__(self, rate: float | None) -> None:
        self._interval = 1e9 / rate if rate else 0.0
        self._intervals: deque[int] | None = None if rate else deque(maxlen=KNOWN)

    def within(self, interval: int) -> int:
        """Number of readings that are missing between two that came; 0 while the rate is not known.

        interval: between the two, ns.
        """
        if self._intervals is not None and interval:
            self._intervals.append(interval)
            if len(self._intervals) >= KNOWN // 10:
                self._interval = float(np.median(self._intervals))
        return max(0, round(interval / self._interval) - 1) if self._interval else 0
