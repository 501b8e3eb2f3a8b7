"""Whether the wall clock of this host was set, by its lead over the monotonic clock, which cannot be."""

from __future__ import annotations

import time

_LEAST = 1_000_000
"""Smallest change that counts, ns: a thread may be held up between two readings."""
_READINGS = 3


def lead() -> int:
    """How far the wall clock is ahead of the monotonic clock now, ns."""
    return max(_difference() for _ in range(_READINGS))


def set_since(before: int) -> int:
    """By how much the wall clock was set since it had the lead `before`, ns; 0 if it was not."""
    if abs(_difference() - before) < _LEAST:
        return 0
    step = lead() - before
    return step if abs(step) >= _LEAST else 0


def _difference() -> int:
    return time.time_ns() - time.monotonic_ns()
