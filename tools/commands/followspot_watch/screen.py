"""A text that renews itself on a terminal."""

from __future__ import annotations

import shutil
from collections.abc import Sequence

BAD = "!"
"""What lines begin with that tell of a fault; on a terminal they are red."""
_HOME_AND_CLEAR, _RED, _PLAIN = "\x1b[H\x1b[J", "\x1b[1;31m", "\x1b[0m"


def screenful(text: str, columns: int | None = None, lines: int | None = None) -> str:
    """What to print so that the text, as much as fits, stands where the last one did.

    columns, lines: of the terminal, as it is now unless told.
    """
    size = shutil.get_terminal_size()
    columns, lines = columns or size.columns, lines or size.lines
    found = text.splitlines()
    shown = found[: lines - 1]
    if len(found) > len(shown):
        shown[-1] = f"... {len(found) - len(shown) + 1} more lines: make the window larger, or see --json"
    return _HOME_AND_CLEAR + "\n".join(_painted(line[:columns]) for line in shown)


def marked(table: str, bad: Sequence[bool]) -> str:
    """A table, of which the rows that are bad begin with the mark of a fault."""
    head, *rows = table.splitlines()
    return "\n".join([head, *(BAD + row[1:] if b else row for row, b in zip(rows, bad, strict=True))])


def _painted(line: str) -> str:
    return f"{_RED}{line}{_PLAIN}" if line.startswith(BAD) else line
