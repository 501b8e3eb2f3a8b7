"""A report that renews itself on a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.live import Live
from rich.segment import Segment

from followspot.tables.terminal import WIDEST, line, literal_console

Draw = Callable[[int | None], RenderableType]
"""Draws a report. It gets the most rows to draw of each table, None for all: rich needs 0.7 ms for a row."""


@dataclass(frozen=True)
class Fitted:
    """As much of a report as fits on the terminal; the last line says if there are more lines."""

    draw: Draw

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render for rich."""
        height = options.max_height
        wide = options.update(width=WIDEST, height=None)
        lines = console.render_lines(self.draw(height + 1), wide, pad=False)
        if len(lines) > height:
            more = line("... more lines: make the window larger, or see --json")
            lines = [*lines[: height - 1], *console.render_lines(more, wide, pad=False)]
        for found in lines:
            yield from Segment.adjust_line_length(found, options.max_width, pad=False)
            yield Segment.line()


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
            console.width = WIDEST  # the terminal wraps lines, and cuts nothing
            for draw in drawn:
                console.print(draw(None))
