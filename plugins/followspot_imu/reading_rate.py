"""Rate of readings from their capture times."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND

MINIMUM_READINGS, MINIMUM_TIME = 32, 0.2
"""Fewest readings, and the shortest time, s, over which their rate is measured."""
MINIMUM_GAP, GAP_PERIODS = 0.25, 10
"""Time, s, and number of periods without a reading beyond which readings are missing."""
RATE_ERROR = 1.25
"""Factor by which the stated rate may differ from the measured one."""


def usual_period(time: Array) -> float | None:
    """The period of readings, s; None if they are too few to tell. time: (N,) rising, ns.

    The median interval, for readings may be missing, of the later half of the time, for the first ones may
    have waited to be read; the mean interval of readings that come in bursts.
    """
    span = int(time[-1] - time[0]) if len(time) else 0
    later = np.diff(time[time - time[:1] >= span / 2])
    enough = len(time) >= MINIMUM_READINGS and len(later) >= MINIMUM_READINGS // 4
    if not enough or span * NANOSECOND < MINIMUM_TIME:
        return None
    median, mean = float(np.median(later)), span / (len(time) - 1)
    return NANOSECOND * (median if 2 * median >= mean else mean)


def gaps_told(time: Array) -> str:
    """How many gaps the readings have, and the longest one; "" if there is none. time: (N,) rising, ns."""
    period = usual_period(time)
    if period is None:
        return ""
    intervals = np.diff(time) * NANOSECOND
    gaps = intervals > max(MINIMUM_GAP, GAP_PERIODS * period)
    if not gaps.any():
        return ""
    longest = int(np.argmax(intervals))
    gap = "a gap" if gaps.sum() == 1 else f"{gaps.sum()} gaps, the longest"
    return f"{gap} of {intervals[longest]:.3g} s without readings after {time[longest] * NANOSECOND:.3f} s"


class RateCheck:
    """Comparison of the stated rate with that of the first readings. rate: Hz; 0 if none is stated."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.time: Array | None = np.zeros(0, np.int64) if rate else None
        """Times of the readings that do not yet suffice, ns; None when nothing remains to be checked."""

    def warning(self, time: Array) -> str:
        """The warning after further readings, once, if the stated rate is wrong; else "". time: (N,) ns."""
        if self.time is None:
            return ""
        self.time = np.concatenate([self.time, time])
        period = usual_period(self.time)
        if period is None:
            return ""
        self.time = None
        if 1 / RATE_ERROR <= period * self.rate <= RATE_ERROR:
            return ""
        return (
            f"{1 / period:.4g} readings come a second where {self.rate:g} are said: orientations will be "
            "wrong; correct the sensor's `rate`, or leave it out"
        )
