"""Progress on standard error: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections import deque
from typing import TextIO

from followspot.library.execute import Progress

_WIDTH = 30
_LINE_EVERY = 5.0
"""Seconds between two lines where the output is no terminal."""
_WINDOW = 5.0
"""Seconds over which the rate is taken: that of a run which stands still is 0, however long it ran before."""
_RED, _PLAIN = "\x1b[1;31m", "\x1b[0m"


class ProgressBar:
    """Shows frames done, the rate, the time left and what is absent. Its `show` is what a run calls."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """stream: standard error as it is now, unless told."""
        self.stream = stream or sys.stderr
        self.started = time.monotonic()
        self.terminal = self.stream.isatty()
        self._next_line = self.started + _LINE_EVERY
        self._drawn = False
        self._faulty = False
        """Whether the last line told of a fault, where the output is no terminal."""
        self._past: deque[tuple[float, int]] = deque()
        """When how many frames were done, s."""

    def show(self, progress: Progress, expected: int | None) -> None:
        """Draw the present state; expected: frames in all, None where nobody knows."""
        now = time.monotonic()
        self._past.append((now, progress.fired))
        while len(self._past) > 2 and now - self._past[1][0] >= _WINDOW:
            self._past.popleft()
        if self.terminal:
            self.stream.write("\r\x1b[K" + self._line(progress, expected, now))
            self.stream.flush()
            self._drawn = True
        elif now >= self._next_line or bool(progress.faults) != self._faulty:
            self._next_line = now + _LINE_EVERY
            self._faulty = bool(progress.faults)
            print(self._line(progress, expected, now), file=self.stream, flush=True)

    def say(self, line: str) -> None:
        """A line of text, above the bar where there is one."""
        before = "\r\x1b[K" if self._drawn else ""
        self._drawn = False
        print(before + line, file=self.stream, flush=True)

    def close(self) -> None:
        """Leave the cursor on a line of its own."""
        if self._drawn:
            self.stream.write("\n")
            self._drawn = False

    def _line(self, progress: Progress, expected: int | None, now: float) -> str:
        return self._frames(progress, expected, now) + self._faults(progress)

    def _faults(self, progress: Progress) -> str:
        if not progress.faults:
            return ""
        more = f" (+{len(progress.faults) - 1})" if len(progress.faults) > 1 else ""
        text = f"! {progress.faults[0]}{more}"
        return f"  {_RED}{text}{_PLAIN}" if self.terminal else f"  {text}"

    def _frames(self, progress: Progress, expected: int | None, now: float) -> str:
        since, before = self._past[0]
        rate = max(0, progress.fired - before) / max(1e-6, now - since)
        if not expected:
            return f"{progress.fired} frames  {rate:.0f}/s"
        share = min(1.0, progress.fired / expected)
        bar = "#" * int(share * _WIDTH)
        left = f"  {(expected - progress.fired) / rate:.0f} s left" if rate > 0 and share < 1.0 else ""
        return f"[{bar:<{_WIDTH}}] {progress.fired}/{expected} frames  {rate:.0f}/s{left}"
