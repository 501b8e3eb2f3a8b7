"""The ledger: for each edge, what became of every message that its sender produced.

produced = sent + away, and sent = delivered + dropped + late + unmatched + invalid + lost + in flight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

DELIVERED, DROPPED, LATE, UNMATCHED, INVALID = range(5)
"""Words of an edge's row that the reader stores."""
SHED, OVERRUN, REFUSED, LOST, AWAY, PRODUCED = range(8, 14)
"""Words that the sender stores: dropped before it left, dropped by a live source, refused before it left, on
the way to readers that died, produced while the reader was away, and produced at all.

Each word has one writer, so a row may lie in memory that two processes share. Of a live source, the thread
that takes what the device gives stores PRODUCED and OVERRUN, the worker's thread the others. A message counts
as produced before it counts as anything else, so whoever reads a row from its first word to its last never
finds more messages accounted for than were produced, even while both ends count.
"""
COLUMNS = 16
"""Words in a row: one cache line for each end of the edge; some are spare."""
LOSSES = ("dropped", "late", "unmatched", "invalid", "lost")
"""Columns of messages that were sent and will not be delivered."""
COUNTS = ("produced", "away", "sent", "delivered", *LOSSES, "in_flight")
"""Columns as they are shown."""


@dataclass(frozen=True)
class EdgeCount:
    """What became of the messages of one edge. No column is negative."""

    produced: int
    """What the stage made: sent + away."""
    away: int
    """Not sent, for the reader was not there."""
    sent: int
    delivered: int
    dropped: int
    late: int
    unmatched: int
    invalid: int
    in_flight: int
    """Sent and not yet accounted for by the reader: 0 after a clean end."""
    lost: int = 0
    """On their way to or from a worker when it died, or to one that was cut off and did not come back."""
    surplus: int = 0
    """Accounted for by the reader beyond what the sender is known to have sent.

    While a run goes on that is a sender whose counts are older than those of the reader. At the end, when all
    have told theirs, it is a bug.
    """

    @property
    def balanced(self) -> bool:
        """Whether every message is accounted for, once; holds at the end of every run that ended cleanly."""
        return self.in_flight == 0 == self.surplus

    def with_lost(self, most: int) -> EdgeCount:
        """At the end of a run nothing is under way: what seems to be was lost with a worker, up to `most`."""
        more = min(self.in_flight, most)
        return replace(self, in_flight=self.in_flight - more, lost=self.lost + more)


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
    """Sum up one row; what is missing is in flight.

    Rows of several hosts that were added up are not of one moment: what readers account for was sent, even
    where the sender has not told of it yet.
    """
    delivered, dropped, late, unmatched, invalid = row[:5]
    shed, overrun, refused, lost, away, produced = row[SHED : PRODUCED + 1]
    dropped += shed + overrun
    invalid += refused
    accounted = delivered + dropped + late + unmatched + invalid
    known = produced - away
    sent = max(known, accounted)
    lost = min(lost, sent - accounted)  # a reader that died may have taken one more than its writer knows
    return EdgeCount(
        produced=sent + away,
        away=away,
        sent=sent,
        delivered=delivered,
        dropped=dropped,
        late=late,
        unmatched=unmatched,
        invalid=invalid,
        in_flight=sent - accounted - lost,
        lost=lost,
        surplus=sent - known,
    )
