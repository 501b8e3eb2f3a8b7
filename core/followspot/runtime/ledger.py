"""The ledger: for each edge, sent = delivered + dropped + late + unmatched + invalid + lost + in flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

SENT, DELIVERED, DROPPED, LATE, UNMATCHED, INVALID, SHED = range(7)
"""Columns of an edge's row. Sent and shed (dropped before it left) are the sender's, the rest the reader's:
each word has one writer, so the row may lie in memory shared by two processes."""
COLUMNS = 8
"""Words in a row; the last is spare, which keeps rows at one cache line."""


@dataclass(frozen=True)
class EdgeCount:
    """What became of the messages of one edge."""

    sent: int
    delivered: int
    dropped: int
    late: int
    unmatched: int
    invalid: int
    in_flight: int
    """Sent and not yet accounted for by the reader: 0 after a clean end."""
    lost: int = 0
    """On their way to or from a worker when it died."""

    @property
    def balanced(self) -> bool:
        """Whether every message is accounted for; holds at the end of every run that ended cleanly."""
        return self.in_flight == 0

    def with_lost(self, most: int) -> EdgeCount:
        """At the end of a run nothing is under way: what seems to be was lost with a worker, up to `most`."""
        lost = max(0, min(self.in_flight, most))
        return replace(self, in_flight=self.in_flight - lost, lost=lost)


class Ledger:
    """Counters of all edges of a graph, one row an edge.

    words: 8-byte integers, len(edges) x COLUMNS; private memory, or shared by the workers of a host so
    that the counts survive the death of any of them.
    """

    def __init__(self, edges: int, words: memoryview | None = None) -> None:
        self.words = memoryview(bytearray(edges * COLUMNS * 8)).cast("q") if words is None else words
        self.edges = edges

    def row(self, edge: int) -> int:
        """Index of the edge's first word; add a column to it."""
        return edge * COLUMNS

    def count(self, edge: int) -> EdgeCount:
        """The present counts of one edge."""
        return tally(self.words[edge * COLUMNS : (edge + 1) * COLUMNS].tolist())


def tally(row: Sequence[int]) -> EdgeCount:
    """Sum up one row; what is missing is in flight."""
    sent, delivered, dropped, late, unmatched, invalid, shed = row[:7]
    accounted = delivered + dropped + late + unmatched + invalid + shed
    return EdgeCount(sent, delivered, dropped + shed, late, unmatched, invalid, sent - accounted)
