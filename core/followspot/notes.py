"""Notes of commands on standard error, beside their results and warnings; --quiet leaves them out."""

from __future__ import annotations

import sys


class _Shown:
    """Whether notes are shown; a process runs one command."""

    now = True


def show_notes(shown: bool) -> None:
    """Show notes in this process, or leave them out."""
    _Shown.now = shown


def note(text: str) -> None:
    """Print a line on standard error, unless notes are left out."""
    if _Shown.now:
        print(text, file=sys.stderr, flush=True)  # noqa: T201


def progress_is_shown() -> bool:
    """Whether a line that renews itself may be shown: standard error is a terminal."""
    return _Shown.now and sys.stderr.isatty()
