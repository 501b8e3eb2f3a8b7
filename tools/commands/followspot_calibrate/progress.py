"""How far a calibration has come, on one line of the terminal; nothing if there is none."""

from __future__ import annotations

import sys


def show_progress(what: str, share: float) -> None:
    """What is being done and which share of it is done, 0 to 1."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{what}: {share:.0%}", end="", file=sys.stderr, flush=True)


def clear_progress() -> None:
    """Wipe that line."""
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
