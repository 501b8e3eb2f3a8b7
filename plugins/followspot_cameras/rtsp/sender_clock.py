"""Capture times of RTP time stamps in this host's clock.

A sender report says what the sender's clock reads at an RTP time stamp, and is sent at that moment. So its
arrival tells how far the sender's clock is off, but for the delay on the way; pictures come much later,
after they were encoded.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from followspot_cameras.rtsp.rtp import SenderReport

REPORTS = 4
"""Newest reports whose least delay counts: 20 s at the usual interval, in which clocks drift by 1 ms."""
WRAP = 1 << 32
LONG_ENOUGH = 60_000_000_000
"""Between the reports that tell the drift, ns: delays of 1 ms then make less than 20 ppm."""
SET = 1_000_000_000
"""A report whose clock is off by so much more or less than the others, ns, shows that a clock was set."""


class SenderClock:
    """rate: RTP time stamps a second."""

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._report: SenderReport | None = None
        self._newest: deque[_Offset] = deque(maxlen=REPORTS)
        self._first: list[_Offset] = []
        self.settings = 0
        """How often one of the clocks was set."""

    @property
    def offset(self) -> int:
        """Offset of this host's clock from the sender's at the newest report, ns: least of recent ones."""
        now, drift = self._newest[-1].clock, self.drift
        return min(one.offset + round(drift * (now - one.clock)) for one in self._newest)

    @property
    def drift(self) -> float:
        """Change of the offset in the sender's time (1e-6: a microsecond a second); 0 while not known."""
        if not self._newest:
            return 0.0
        then, now = min(self._first, key=_least), min(self._newest, key=_least)
        passed = now.clock - then.clock
        return (now.offset - then.offset) / passed if passed >= LONG_ENOUGH else 0.0

    def add(self, report: SenderReport, arrival: int) -> None:
        """Take a report. arrival: by this host's clock, ns."""
        told = _Offset(report.clock, arrival - report.clock)
        if self._newest and abs(told.offset - self.offset) > SET:
            self._newest.clear()
            self._first.clear()
            self.settings += 1
        self._newest.append(told)
        if len(self._first) < REPORTS:
            self._first.append(told)
        self._report = report

    def capture_time(self, timestamp: int) -> int | None:
        """Time of a picture, ns; None before the first report. timestamp: 32 bits, near the last report's."""
        if self._report is None:
            return None
        ahead = (timestamp - self._report.timestamp + WRAP // 2) % WRAP - WRAP // 2
        passed = ahead * 10**9 // self._rate
        return self._report.clock + passed + self.offset + round(self.drift * passed)


class _Offset(NamedTuple):
    """Of a report: the sender's clock, and what this host's is ahead of it, ns."""

    clock: int
    offset: int


def _least(one: _Offset) -> int:
    return one.offset
