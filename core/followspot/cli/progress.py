"""Progress on standard error: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import TextIO

from followspot.runtime.worker import Progress

_WIDTH = 30
_LINE_EVERY = 5.0
"""Seconds between two lines where the output is no terminal."""


class ProgressBar:
    """Shows frames done, the rate and the time left. Its `show` is what a run calls."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """stream: standard error as it is now, unless told."""
        self.stream = stream or sys.stderr
        self.started = time.monotonic()
        self.terminal = self.stream.isatty()
        self._next_line = self.started + _LINE_EVERY
        self._drawn = False

    def show(self, progress: Progress, expected: int | None) -> None:
        """Draw the present state; expected: frames in all, None where nobody knows."""
        now = time.monotonic()
        if self.terminal:
            self.stream.write("\r\x1b[K" + self._line(progress, expected, now))
            self.stream.flush()
            self._drawn = True
        elif now >= self._next_line:
            self._next_line = now + _LINE_EVERY
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
        rate = progress.fired / max(1e-6, now - self.started)
        if not expected:
            return f"{progress.fired} frames  {rate:.0f}/s"
        share = min(1.0, progress.fired / expected)
        bar = "#" * int(share * _WIDTH)
        left = f"  {(expected - progress.fired) / rate:.0f} s left" if rate > 0 and share < 1.0 else ""
        return f"[{bar:<{_WIDTH}}] {progress.fired}/{expected} frames  {rate:.0f}/s{left}"
