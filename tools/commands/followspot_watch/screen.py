"""A report that renews itself on a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.live import Live
from rich.segment import Segment

from followspot.tables import line, literal_console

Draw = Callable[[int | None], RenderableType]
"""Draws a report. It gets the most rows to draw of each table, None for all: rich needs 0.7 ms for a row."""


@dataclass(frozen=True)
class Fitted:
    """As many lines of a report as fit on the terminal; the last line says that there are more."""

    draw: Draw

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """What rich calls."""
        height = options.max_height
        lines = console.render_lines(self.draw(height + 1), options.update(height=None), pad=False)
        for found in lines if len(lines) <= height else lines[: height - 1]:
            yield from found
            yield Segment.line()
        if len(lines) > height:
            yield line("... more lines: make the window larger, or see --json")


@contextmanager
def live_screen() -> Iterator[Callable[[Draw], None]]:
    """Gives a function that shows a report in place of the one before. The last stays when the block ends."""
    console, drawn = literal_console(), list[Draw]()
    with Live(console=console, screen=True, auto_refresh=False) as live:

        def show(draw: Draw) -> None:
            drawn[:] = [draw]
            live.update(Fitted(draw), refresh=True)

        try:
            yield show
        finally:
            live.stop()
            for draw in drawn:
                console.print(draw(None))
