"""Tables for people, drawn by rich: on a terminal, or as plain text for pipes and files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table

BAD = "!"
"""First character of a line that reports a fault."""
BAD_STYLE = "bold red"
"""How a terminal shows such a line."""
_WIDEST = 1_000_000
"""Columns of plain text: so many that rich wraps no line."""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as plain text, indented by two spaces: first column to the left, others to the right."""
    return plain(grid(head, rows))


def grid(head: Sequence[str], rows: Sequence[Sequence[str]], bad: Sequence[bool] = ()) -> Table:
    """The same table for rich to draw. bad: whether each row reports a fault."""
    from rich.table import Table

    drawn = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="")
    drawn.add_column(f"  {head[0]}", no_wrap=True)
    for name in head[1:]:
        drawn.add_column(name, justify="right", no_wrap=True)
    for row, is_bad in zip(rows, bad or [False] * len(rows), strict=True):
        drawn.add_row(f"{BAD if is_bad else ' '} {row[0]}", *row[1:], style=BAD_STYLE if is_bad else "")
    return drawn


def plain(*parts: RenderableType) -> str:
    """What rich draws, without escape codes and without wrapped lines."""
    console = literal_console(width=_WIDEST, color_system=None)
    with console.capture() as capture:
        console.print(*parts, sep="\n")
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def literal_console(**options: Any) -> Console:
    """A console that prints text as it is: no markup, no emoji codes, no highlights. options: of rich."""
    from rich.console import Console

    return Console(markup=False, emoji=False, highlight=False, **options)
