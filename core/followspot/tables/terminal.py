"""Tables for people, drawn by rich: on a terminal, or as plain text for pipes and files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich.console import Console, Group, RenderableType
    from rich.table import Table
    from rich.text import Text

_BAD, BAD_STYLE = "!", "bold red"
"""First character of a line that reports a fault, and how a terminal shows the line."""
WIDEST = 1_000_000
"""Columns of plain text: so many that rich wraps no line."""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as plain text, indented by two spaces: first column to the left, others to the right."""
    return plain(grid(head, rows))


def grid(head: Sequence[str], rows: Sequence[Sequence[str]], bad: Sequence[bool] = ()) -> Table:
    """The table as an object of rich. bad: whether each row reports a fault."""
    from rich.table import Table

    drawn = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="")
    for i, name in enumerate((f"  {head[0]}", *head[1:])):
        drawn.add_column(name, justify="right" if i else "left", no_wrap=True)
    for row, is_bad in zip(rows, bad or [False] * len(rows), strict=True):
        drawn.add_row(f"{_BAD if is_bad else ' '} {row[0]}", *row[1:], style=BAD_STYLE if is_bad else "")
    return drawn


def line(text: str, *, bad: bool = False) -> Text:
    """A line for rich to draw. bad: whether it reports a fault."""
    from rich.text import Text

    return Text(f"{_BAD} {text}" if bad else text, BAD_STYLE if bad else "")


def blocks(*parts: Sequence[RenderableType]) -> Group:
    """Parts for rich to draw, an empty line between two; an empty part is left out."""
    from rich.console import Group

    first, *others = (part for part in parts if part)
    return Group(*first, *(one for part in others for one in ("", *part)))


def plain(part: RenderableType) -> str:
    """An object of rich as text, without escape codes and wrapped lines."""
    console = literal_console(width=WIDEST, color_system=None)
    with console.capture() as capture:
        console.print(part)
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def is_screen(stream: TextIO) -> bool:
    """True if the stream is a terminal that can overwrite lines."""
    return stream.isatty() and os.environ.get("TERM", "").lower() not in ("dumb", "unknown")


def literal_console(**options: Any) -> Console:
    """A console that prints text as it is: no markup, no emoji codes, no highlights. options: of rich."""
    from rich.console import Console

    return Console(markup=False, emoji=False, highlight=False, **options)
