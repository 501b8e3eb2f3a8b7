"""How regularly a port sends, measured where it does."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

import numpy as np

from followspot import Field, InputPath, Message, Stage, StageParams
from followspot.messages import stamped
from followspot_dashboard.line import Line, PostLine, line_of

MOST = 4096
"""Messages that are remembered at most; of a port that sends more in the window, the newest count."""


class Rhythm(Message):
    """The messages of a port within a window, and the gaps between them.

    count: messages since the meter began; rate: 1/s; mean_ms, jitter_ms (standard deviation), p95_ms,
    worst_ms: of the gaps; 0 where there are fewer than two messages.
    """

    count: int
    rate: float
    mean_ms: float
    jitter_ms: float
    p95_ms: float
    worst_ms: float


class Meter(Stage):
    """Tell `followspot hz` now and then how regularly a port sends."""

    class Params(StageParams):
        folder: InputPath | None = Field(
            None, description="folder of the reader's sockets, if the reader is on this host"
        )
        port: str = Field("", description="observed port, STAGE.PORT; by default this stage's name")
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
    tap = True
    line: Line | PostLine | None = None
    monotonic_ns: Callable[[], int] = staticmethod(time.monotonic_ns)
    """A clock, ns."""

    def setup(self) -> None:
        """Find who reads; without them, nothing is measured."""
        self.port = self.params.port or self.context.name
        self.window = int(self.params.window * 1e9)
        self.every = int(self.params.report_interval * 1e9)
        self.count = self.tell_at = 0
        self.times: deque[int] = deque(maxlen=MOST)
        self.line = line_of(self.context, self.params.folder)

    def process(self, message: Message) -> None:
        """Note when the message came. Raises EOFError when nobody reads any more."""
        line = self.line
        if line is not None and line.deserted:
            raise EOFError("nobody reads any more")
        if line is None:
            return
        now = self.monotonic_ns()
        self.count += 1
        self.times.append(now)
        if now < self.tell_at:
            return
        self.tell_at = now + self.every
        if line.watched:
            times = np.array(self.times)
            line.send(
                self.port, stamped(rhythm(self.count, times[times >= now - self.window]), message.header)
            )

    def close(self) -> None:
        """Let go of the line."""
        if self.line is not None:
            self.line.close()
        self.line = None


def rhythm(count: int, times: np.ndarray) -> Rhythm:
    """Of messages that came at these times, ns, rising; count: of all messages."""
    if len(times) < 2:
        return Rhythm(count, 0.0, 0.0, 0.0, 0.0, 0.0)
    gaps = np.diff(times) / 1e6
    mean = float(gaps.mean())
    p95 = float(np.sort(gaps)[int(0.95 * (len(gaps) - 1) + 0.5)])
    return Rhythm(count, 1e3 / max(mean, 1e-6), mean, float(gaps.std()), p95, float(gaps.max()))
