"""The ledger: for each edge, what became of every message that its sender produced.

produced = sent + away, and sent = delivered + dropped + late + unmatched + invalid + lost + in flight.
Frames that were lost between a device and its source have columns of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

DELIVERED, DROPPED, LATE, UNMATCHED, INVALID = range(5)
"""Words of an edge's row that the reader stores."""
SHED, OVERRUN, REFUSED, LOST, AWAY, PRODUCED, FILLED = range(8, 15)
"""Words that the sender stores: dropped before sending, dropped by a live source, refused before sending, on
the way to readers that died, produced while the reader was away, and produced at all. FILLED is no count:
it is above 0 if one of the messages had rows.

Each word has one writer, so two processes may share a row. The thread of a live source stores PRODUCED,
OVERRUN and what is lost at the source, the worker's thread the others. A message counts as produced before it
counts as anything else, so a process that reads a row from its first word to its last never finds more
messages accounted for than were produced, even while both ends count.
"""
SOURCE_LOSSES = {"packet_loss": 15, "device_overrun": 7, "gap": 6}
"""Words of frames lost at the source, which the sender stores, too: frames that came without some packets,
that the host dropped because the source was late, and that the camera's numbers skip for an unknown reason.
They count beside the messages of the edge."""
COLUMNS = 16
"""Words in a row: one cache line for each end of the edge; word 5 is unused."""
LOSSES = ("dropped", "late", "unmatched", "invalid", "lost")
"""Columns of messages that were sent and will not be delivered."""
COUNTS = ("produced", "away", "sent", "delivered", *LOSSES, "in_flight")
"""Columns in the order in which they are shown."""


@dataclass(frozen=True)
class EdgeCount:
    """The fate of all messages of one edge. No column is negative."""

    produced: int
    """Messages that the stage made: sent + away."""
    away: int
    """Messages that were not sent, because the reader was away."""
    sent: int
    delivered: int
    dropped: int
    late: int
    unmatched: int
    invalid: int
    in_flight: int
    """Messages that were sent and that the reader has not yet accounted for: 0 after a clean end."""
    lost: int = 0
    """Messages on their way to or from a worker that died, or to one that was cut off for good."""
    surplus: int = 0
    """Messages that the reader accounts for beyond those that the sender is known to have sent.

    During a run the sender's counts may be older than the reader's. At the end of a run a surplus is a bug.
    """
    filled: bool = False
    """True if a message with rows was produced."""
    packet_loss: int = 0
    """Frames of a device that came to its source with packets missing."""
    device_overrun: int = 0
    """Frames of a device that were given up before its source took them."""
    gap: int = 0
    """Frames of a device that never came, by their numbers."""

    @property
    def balanced(self) -> bool:
        """Whether every message is accounted for once; holds at the end of every run that ended cleanly."""
        return self.in_flight == 0 == self.surplus

    def with_lost(self, most: int) -> EdgeCount:
        """The count at the end of a run: up to `most` messages in flight were lost with a worker."""
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
    """Sum up one row; a message that is not accounted for is in flight.

    Rows of several hosts that were added up are not of one moment: what readers account for was sent, even if
    the sender has not reported it yet.
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
        filled=row[FILLED] > 0,
        **{name: row[word] for name, word in SOURCE_LOSSES.items()},
    )
