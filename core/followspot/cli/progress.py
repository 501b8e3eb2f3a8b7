"""Progress on standard error: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from followspot.library.execute import Progress
from followspot.tables.terminal import BAD_STYLE, is_screen, literal_console

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress as Bar

_NAMES = 4
"""Stages that are named at most."""
_LINE_EVERY = 5.0
"""Seconds between two lines if standard error is no terminal, and over which a bar takes the rate."""
_LEAST = 1.0
"""Shortest time that gives a rate, s."""


class ProgressBar:
    """Shows frames done, the rate, the time left, faults, and the sinks that a stopped run still waits for.

    Its `show` is what a run calls.
    """

    def __init__(self) -> None:
        self.terminal = is_screen(sys.stderr)
        self._line = self._shown = time.monotonic()
        """When the last line was printed, and when a state came last, s."""
        self._rate = _Rate(_LINE_EVERY if self.terminal else _LEAST)
        self._line_state = False, False
        """Whether the last line had a fault, and a stop."""

    def show(self, progress: Progress, expected: int | None) -> None:
        """Draw the present state. expected: frames in all, None if the sources do not tell."""
        fault = ""
        if progress.faults:
            more = f" (+{len(progress.faults) - 1})" if len(progress.faults) > 1 else ""
            fault = f"! {progress.faults[0]}{more}"
        stop = f"stopped; still to be finished: {_some(progress.unfinished)}" if progress.unfinished else ""
        notes = "  ".join(note for note in (stop, fault) if note)
        now = time.monotonic()
        # after a pause of this process, the first state may be as old as the pause
        fresh, self._shown = now - self._shown <= _LINE_EVERY, now
        if self.terminal:
            rate = self._rate.at(now, progress.fired, fresh=fresh)
            self._draw(progress.fired, expected or None, rate, notes)
            return
        state = bool(fault), bool(stop)
        if now >= self._line + _LINE_EVERY or state != self._line_state:
            self._line, self._line_state = now, state
            rate = self._rate.at(now, progress.fired, fresh=fresh)
            self.say(f"{_frames(progress.fired, expected, rate)}  {notes}".rstrip())

    def say(self, line: str) -> None:
        """Print a line of text, above the bar if there is one."""
        if self.terminal:
            self._console.print(line, soft_wrap=True)
        else:
            print(line, file=sys.stderr, flush=True)

    def close(self) -> None:
        """End the bar; its last state stays."""
        if "_bar" in vars(self):
            self._bar.stop()

    @cached_property
    def _console(self) -> Console:
        return literal_console(stderr=True)

    @cached_property
    def _bar(self) -> Bar:
        """A bar with its one task, drawn whenever `show` is called."""
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as Bar
        from rich.table import Column

        bar = Bar(
            BarColumn(bar_width=30),
            TextColumn("{task.fields[frames]}", markup=False),
            TextColumn(
                "{task.fields[notes]}", style=BAD_STYLE, markup=False, table_column=Column(no_wrap=True)
            ),
            console=self._console,
            auto_refresh=False,
            redirect_stdout=False,
        )
        bar.add_task("", frames="", notes="")
        return bar

    def _draw(self, fired: int, expected: int | None, rate: float, notes: str) -> None:
        (task,) = self._bar.tasks
        self._bar.update(task.id, completed=fired, total=expected)
        self._bar.update(task.id, frames=_frames(fired, expected, rate), notes=notes, refresh=True)
        self._bar.start()  # does nothing if it has begun


class _Rate:
    """Frames a second, averaged over the last `over` seconds or a little more."""

    def __init__(self, over: float) -> None:
        self._over = over
        self._counts = deque([(time.monotonic(), 0)])

    def at(self, now: float, fired: int, *, fresh: bool) -> float:
        """The rate until now, Hz; 0 if the first count is too recent.

        now: s, monotonic; fired: frames so far; fresh: whether that count is of now. An older count begins no
        later average.
        """
        while len(self._counts) > 1 and self._counts[1][0] <= now - self._over:
            self._counts.popleft()
        since, before = self._counts[0]
        if fresh:
            self._counts.append((now, fired))
        return max(0, fired - before) / (now - since) if now - since >= _LEAST else 0.0


def _some(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = f" and {len(names) - _NAMES} more" if len(names) > _NAMES else ""
    return ", ".join(names[:_NAMES]) + more


def _frames(fired: int, expected: int | None, rate: float) -> str:
    if not expected:
        return f"{fired} frames  {rate:.0f}/s"
    left = f"  {(expected - fired) / rate:.0f} s left" if rate > 0 and fired < expected else ""
    return f"{fired}/{expected} frames  {rate:.0f}/s{left}"
