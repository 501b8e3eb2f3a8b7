"""Progress of a calibration on one line of the terminal; nothing without a terminal."""

from __future__ import annotations

import sys

from followspot.notes import progress_is_shown


def show_progress(what: str, share: float) -> None:
    """The present step as text, and the completed share, 0 to 1."""
    if progress_is_shown():
        print(f"\r\x1b[K{what}: {share:.0%}", end="", file=sys.stderr, flush=True)


def clear_progress() -> None:
    """Wipe that line."""
    if progress_is_shown():
        print("\r\x1b[K", end="", file=sys.stderr)
