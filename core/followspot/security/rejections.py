"""Refusals of one kind or another: each is counted, and logged as long as that does not fill the log."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

_LOGGED = 20
"""Refusals of a kind that are logged one by one; then each hundredth."""


class Rejections:
    """tell: gets lines for the log."""

    def __init__(self, tell: Callable[[str], None] = lambda line: None) -> None:
        self.counts: Counter[str] = Counter()
        """By reason."""
        self._tell = tell

    def add(self, reason: str, who: str, why: str) -> None:
        """One more; who: the key of the request, or the peer; why: for the log."""
        self.counts[reason] += 1
        number = self.counts[reason]
        if number <= _LOGGED or number % 100 == 0:
            self._tell(f"refused ({reason}, {number}): {who[:200]}: {why[:500]}")

    def sum_up(self, what: str) -> None:
        """Log all counts, where there are any; what: was refused."""
        if self.counts:
            listing = ", ".join(f"{number} {reason}" for reason, number in sorted(self.counts.items()))
            self._tell(f"{what} refused: {listing}")
