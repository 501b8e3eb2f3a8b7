"""Counts of faults; the first of each kind is reported at once, the sums at the end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from followspot.errors import printable


class Tally:
    """warn: tells the user."""

    def __init__(self, name: str, warn: Callable[[str], None]) -> None:
        self.counts: Counter[str] = Counter()
        self._name, self._warn = name, warn

    def add(self, what: str, number: int = 1, why: str = "") -> None:
        """Count, and tell the first.

        what: in the plural, such as "datagrams that cannot be read"; why: may repeat what was received.
        """
        if number <= 0:
            return
        if not self.counts[what]:
            self._warn(f"{self._name}: first {what}{why and ': '}{printable(why)}")
        self.counts[what] += number

    def tell(self) -> None:
        """Tell the sums."""
        if self.counts:
            sums = ", ".join(f"{number} {what}" for what, number in sorted(self.counts.items()))
            self._warn(f"{self._name}: {sums}")
            self.counts.clear()
