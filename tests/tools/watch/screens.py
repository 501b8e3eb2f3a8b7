"""What a terminal shows of a report."""

from __future__ import annotations

from io import StringIO

from followspot.tables.terminal import literal_console
from followspot_watch.screen import Draw, Fitted


def on_terminal(draw: Draw, columns: int, lines: int) -> list[str]:
    """The lines of a terminal of this size, with escape codes."""
    console = literal_console(
        file=StringIO(), force_terminal=True, width=columns, height=lines, color_system="standard"
    )
    with console.capture() as capture:
        console.print(Fitted(draw), end="")
    return [line.rstrip() for line in capture.get().splitlines()]
