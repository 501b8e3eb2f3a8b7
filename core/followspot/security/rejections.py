"""Counts rejections by reason, and logs them without filling the log."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

_LOGGED = 20
"""Rejections of a reason that are logged singly; after these, every hundredth is."""


class Rejections:
    """Counts rejections. log_line: gets lines for the log."""

    def __init__(self, log_line: Callable[[str], None] = lambda line: None) -> None:
        self.counts: Counter[str] = Counter()
        """Number of rejections by reason."""
        self._log_line = log_line

    def add(self, reason: str, sender: str, why: str) -> None:
        """Count a rejection. sender: the key of the request, or the peer; why: text for the log."""
        self.counts[reason] += 1
        number = self.counts[reason]
        if number <= _LOGGED or number % 100 == 0:
            self._log_line(f"refused ({reason}, {number}): {sender[:200]}: {why[:500]}")

    def sum_up(self, what: str) -> None:
        """Log all counts, if there are any. what: the rejected things, "requests" or "peers"."""
        if self.counts:
            listing = ", ".join(f"{number} {reason}" for reason, number in sorted(self.counts.items()))
            self._log_line(f"{what} refused: {listing}")
