"""Capture times of RTP time stamps in this computer's clock.

A sender report says what the sender's clock reads at an RTP time stamp, and is sent at that moment. So its
arrival tells how far the sender's clock is off, but for the delay on the way; pictures come much later,
after they were encoded.
"""

from __future__ import annotations

from collections import deque

from followspot_cameras.rtsp.rtp import SenderReport

REPORTS = 4
"""Newest reports whose least delay counts: 20 s at the usual interval, in which clocks drift by 1 ms."""
WRAP = 1 << 32
SET = 1_000_000_000
"""A report whose clock is off by so much more or less than the others, ns, shows that a clock was set."""


class SenderClock:
    """rate: RTP time stamps a second."""

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._report: SenderReport | None = None
        self._offsets: deque[int] = deque(maxlen=REPORTS)
        self.settings = 0
        """How often one of the clocks was set."""

    @property
    def reported(self) -> bool:
        """Whether the sender has told its clock."""
        return self._report is not None

    @property
    def offset(self) -> int:
        """What is added to the sender's clock, ns: the least of the newest reports."""
        return min(self._offsets)

    def add(self, report: SenderReport, arrival: int) -> None:
        """Take a report. arrival: by this computer's clock, ns."""
        offset = arrival - report.clock
        if self._offsets and abs(offset - self.offset) > SET:
            self._offsets.clear()
            self.settings += 1
        self._offsets.append(offset)
        self._report = report

    def capture_time(self, timestamp: int) -> int | None:
        """Time of a picture, ns; None before the first report. timestamp: 32 bits, near the last report's."""
        if self._report is None:
            return None
        ahead = (timestamp - self._report.timestamp + WRAP // 2) % WRAP - WRAP // 2
        return self._report.clock + ahead * 10**9 // self._rate + self.offset
