"""The offset between the clocks of two hosts, from timed exchanges (Mills, RFC 5905, section 8).

The other host read its clock between request and reply, so an exchange gives the offset to within half its
round trip. The exchanges with the shortest round trips are the most exact.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from statistics import median

_KEPT = 16
"""Number of newest exchanges that are used."""
_BEST = 5
"""Number of these with the shortest round trips; the offset is their median."""
_TOLERANCE = 1_000_000
"""Tolerance of drift and late threads, ns; if bounds differ by more, a clock has been set."""


@dataclass(frozen=True)
class Exchange:
    """One exchange. captured, steady: reading of the other host's clock less ours at half the round trip, ns;
    round_trip: ns.
    """

    captured: int
    steady: int
    round_trip: int


class ClockFilter:
    """The offset to another host's clocks from the newest exchanges."""

    def __init__(self) -> None:
        self._kept: deque[Exchange] = deque(maxlen=_KEPT)

    def add(self, exchange: Exchange) -> None:
        """Add an exchange; if it contradicts the others, a clock has been set, and they are dropped."""
        if self._kept and not self._agrees(exchange):
            self._kept.clear()
        self._kept.append(exchange)

    @property
    def exchanges(self) -> int:
        """The number of exchanges that are used."""
        return len(self._kept)

    def offset(self) -> Exchange | None:
        """The median offsets of the best exchanges and their longest round trip; None before the first."""
        best = sorted(self._kept, key=lambda exchange: exchange.round_trip)[:_BEST]
        if not best:
            return None
        captured = round(median(exchange.captured for exchange in best))
        return Exchange(captured, round(median(exchange.steady for exchange in best)), best[-1].round_trip)

    def _agrees(self, exchange: Exchange) -> bool:
        known = self.offset()
        assert known is not None
        bound = (known.round_trip + exchange.round_trip) // 2 + _TOLERANCE
        return (
            abs(exchange.captured - known.captured) <= bound and abs(exchange.steady - known.steady) <= bound
        )
