"""What the readers of a ring do: read, consume, keep messages, and let go of them."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.stateful import precondition, rule
from tests.promises.edge_messages import intact
from tests.promises.ring_ends import RingEnds

READERS = st.integers(0, 2)
FEW = st.integers(1, 4)


class ReadingRing(RingEnds):
    """Rules of the reading ends."""

    @rule(index=READERS)
    def read(self, index: int) -> None:
        if (found := self.reader(index)) is not None:
            self.take(index, found)

    @rule(index=READERS, count=FEW, forget=st.booleans())
    def consume(self, index: int, count: int, forget: bool) -> None:
        found = self.reader(index)
        owed = self.port.readers[index] if found is not None else None
        if found is None or owed is None:
            return
        count = min(count, owed.got - owed.consumed)
        if count:
            owed.consume(count)
            found.consumed(count)
        if forget:
            self.forget(index, count)

    @precondition(lambda self: any(self.kept))
    @rule(index=READERS, count=FEW)
    def forget(self, index: int, count: int) -> None:
        """The reading stage lets go of messages that it kept, unchanged as they are."""
        if index < len(self.kept):
            assert all(map(intact, self.kept[index]))
            del self.kept[index][:count]

    def all_read(self, hoards: set[int]) -> bool:
        """Readers that are woken read, consume, and keep or release; whether any did."""
        moved = False
        for index, owed in enumerate(self.port.readers):
            if (found := self.readers[index]) is not None and owed is not None:
                woken, before = self.readable(found.fileno()), owed.consumed
                if woken:
                    self.take(index, found)
                self.consume(index, self.port.depth, forget=False)
                self.forget(index, 0)
                mine = index if index in hoards else -1
                self.kept[index] = [kept for kept in self.kept[index] if kept.header.seq % 3 == mine]
                moved |= woken or owed.consumed > before
        return moved
