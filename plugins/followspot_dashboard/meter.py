"""How regularly a port sends, measured in the worker that sends."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

import numpy as np

from followspot import Field, Message
from followspot.messages import stamped
from followspot.taps.port_tap import PortTap

MOST = 4096
"""Largest number of remembered messages; the oldest are dropped if the window has more."""


class Rhythm(Message):
    """The messages of a port within a window, and the gaps between them.

    count: messages since the meter began; rate: 1/s; mean_ms, jitter_ms (standard deviation), p95_ms,
    worst_ms: of the gaps; 0 if there are fewer than two messages.
    """

    count: int
    rate: float
    mean_ms: float
    jitter_ms: float
    p95_ms: float
    worst_ms: float


class Meter(PortTap):
    """Report to `followspot hz` how regularly a port sends."""

    class Params(PortTap.Params):
        window: float = Field(
            5.0,
            gt=0,
            le=3600,
            unit="s",
            description="time over which the rate is measured; raising it smooths it",
        )
        report_interval: float = Field(
            0.5, gt=0, le=60, unit="s", description="shortest time between two reports"
        )

    params: Params
    monotonic_ns: Callable[[], int] = staticmethod(time.monotonic_ns)
    """A clock, ns."""

    def setup(self) -> None:
        """Connect to the reader."""
        super().setup()
        self.window = int(self.params.window * 1e9)
        self.every = int(self.params.report_interval * 1e9)
        self.count = self.tell_at = 0
        self.times: deque[int] = deque(maxlen=MOST)

    def process(self, message: Message) -> None:
        """Note when the message came. Raises EOFError if the reader has left."""
        awaited = self.awaited()
        now = self.monotonic_ns()
        self.count += 1
        self.times.append(now)
        if now < self.tell_at:
            return
        self.tell_at = now + self.every
        if awaited:
            times = np.array(self.times)
            self.send(stamped(rhythm(self.count, times[times >= now - self.window]), message.header))


def rhythm(count: int, times: np.ndarray) -> Rhythm:
    """The rhythm of messages with these ascending arrival times, ns; count: of all messages."""
    if len(times) < 2:
        return Rhythm(count, 0.0, 0.0, 0.0, 0.0, 0.0)
    gaps = np.diff(times) / 1e6
    mean = float(gaps.mean())
    p95 = float(np.sort(gaps)[int(0.95 * (len(gaps) - 1) + 0.5)])
    return Rhythm(count, 1e3 / max(mean, 1e-6), mean, float(gaps.std()), p95, float(gaps.max()))
