"""How far two clocks are apart, from questions and answers that take their time (Mills, RFC 5905, section 8).

An answer was given somewhere between question and reply, so each exchange bounds the offset by half its round
trip; the quickest exchanges bound it best.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from statistics import median

_KEPT = 16
"""Newest exchanges that count."""
_BEST = 5
"""Of these, the quickest, whose median is the offset."""
_SLACK = 1_000_000
"""ns by which bounds may miss each other before a clock counts as set: drift, and threads that wake late."""


@dataclass(frozen=True)
class Exchange:
    """One question: what the other clocks read less what ours did half-way, and the round trip; all ns."""

    captured: int
    steady: int
    round_trip: int


class ClockFilter:
    """The offset to another host's clocks from the newest exchanges."""

    def __init__(self) -> None:
        self._kept: deque[Exchange] = deque(maxlen=_KEPT)

    def add(self, exchange: Exchange) -> None:
        """One more; where it contradicts the others, a clock was set, and they count no more."""
        if self._kept and not self._agrees(exchange):
            self._kept.clear()
        self._kept.append(exchange)

    @property
    def exchanges(self) -> int:
        """How many count."""
        return len(self._kept)

    def offset(self) -> Exchange | None:
        """The median offsets, and the longest round trip among those; None before the first exchange."""
        best = sorted(self._kept, key=lambda exchange: exchange.round_trip)[:_BEST]
        if not best:
            return None
        captured = round(median(exchange.captured for exchange in best))
        return Exchange(captured, round(median(exchange.steady for exchange in best)), best[-1].round_trip)

    def _agrees(self, exchange: Exchange) -> bool:
        known = self.offset()
        assert known is not None
        bound = (known.round_trip + exchange.round_trip) // 2 + _SLACK
        return (
            abs(exchange.captured - known.captured) <= bound and abs(exchange.steady - known.steady) <= bound
        )
