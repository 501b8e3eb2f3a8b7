"""Faults of a Zenoh edge: ends that die, return or are replaced, and a cable that is cut and mended."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.stateful import precondition, rule
from tests.promises.edge_messages import Picture
from tests.promises.edge_model import END, Advance, Owed
from tests.promises.zenoh_ends import ZenohEnds
from tests.promises.zenoh_hosts import READERS

from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter


class ZenohFaults(ZenohEnds):
    """The rules that take away ends and the cable between their hosts, and bring them back."""

    @rule(index=st.integers(0, 1), with_host=st.booleans())
    def reader_dies(self, index: int, with_host: bool) -> None:
        """Alone, or with its host."""
        reader = self.readers[index]
        if reader is not None:
            if with_host:
                self.hosts.reader_host_dies(index)
            reader.close()
            self.readers[index] = None
            self.taken[index].clear()

    @rule(index=st.integers(0, 1))
    def reader_returns(self, index: int) -> None:
        """As another incarnation, on the host of the one before or on another."""
        if self.readers[index] is not None:
            return
        self.readers[index] = ZenohReader(
            self.hosts.of_reader(index),
            self.key,
            f"reader {index}",
            Picture,
            self.depth,
            incarnation=self.readers_before[index],
        )
        self.readers_before[index] += 1
        self.eras[index] = [Owed(joins=True, leaks=self.leaks(index), announced=self.announced)]
        if self.over:
            self.owed[index].say(Advance(END))

    @precondition(lambda self: not self.replaced)
    @rule(index=st.integers(0, 1))
    def reader_is_replaced(self, index: int) -> None:
        """It seems gone, so another incarnation comes; then it is back for a while, and leaves."""
        reader = self.readers[index]
        if reader is not None:
            self.replaced.append(reader)
            self.readers[index] = None
            self.taken[index].clear()
            self.reader_returns(index)

    @precondition(lambda self: self.writer and not self.replaced)
    @rule(with_host=st.booleans())
    def writer_dies(self, with_host: bool) -> None:
        assert self.writer is not None
        if with_host:
            self.hosts.writer_host_dies(self.writer_host)
            self.apart &= self.writer_host != 0
        self.writer.close()
        self.writer = None

    @precondition(lambda self: not self.writer)
    @rule(host=st.integers(0, 1))
    def writer_returns(self, host: int) -> None:
        """On the host of the one before, or on another."""
        self.writer = ZenohWriter(
            self.hosts.of_writer[host],
            self.key,
            {f"reader {index}": "" for index in range(READERS)},
            self.depth,
            incarnation=self.writers_before,
        )
        self.writers_before += 1
        self.writer_host = host
        self.over = self.asleep = False
        self.announced = set()
        for index, eras in enumerate(self.eras):
            eras.append(Owed(leaks=self.leaks(index), vague=True, announced=self.announced))

    @precondition(lambda self: self.speaks and not self.replaced and not self.apart)
    @rule()
    def writer_is_replaced(self) -> None:
        """It seems gone, so another incarnation comes; then it is back for a while, and leaves."""
        assert self.writer is not None
        self.replaced.append(self.writer)
        self.writer = None
        self.writer_returns(1 - self.writer_host)

    @precondition(lambda self: self.replaced)
    @rule()
    def replaced_end_leaves(self) -> None:
        self.replaced.pop(0).close()

    @precondition(lambda self: not self.apart)
    @rule(held=st.booleans())
    def cut(self, held: bool) -> None:
        self.apart = self.was_cut = True
        self.hosts.cable.hold() if held else self.hosts.cable.cut()
        for owed in self.eras[0]:
            owed.leaks = True

    @precondition(lambda self: self.apart)
    @rule(lost=st.booleans())
    def mend(self, lost: bool) -> None:
        """What was held arrives, or is lost."""
        self.apart = False
        if lost:
            self.hosts.cable.cut()
        self.hosts.cable.mend()
        self.hosts.cable.release()
