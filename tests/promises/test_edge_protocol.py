"""A ring keeps what an edge promises, in whatever order its ends send, read, sleep, die and return."""

from __future__ import annotations

import socket
import sys

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule
from tests.promises.edge_model import Owed
from tests.promises.ring_ends import open_descriptors
from tests.promises.ring_reading import READERS
from tests.promises.ring_writing import WritingRing

from followspot.transport.ring.links import ReaderLocation
from followspot.transport.ring.writer import RingWriter

HOMES = ["abc", "aab", "aba", "aaa"]


class RingEdge(WritingRing):
    """A port with three readers; each end is moved by what its descriptors say, and at odd times."""

    @initialize(readers=st.integers(1, 3), depth=st.sampled_from([1, 2, 4]), homes=st.sampled_from(HOMES))
    def begin(self, readers: int, depth: int, homes: str) -> None:
        """homes: the process of each reader; those of one process share datagrams at first."""
        self.set_up(readers, depth)
        self.homes = homes
        self.writer_returns()

    # Deaths and returns.

    @precondition(lambda self: any(self.readers))
    @rule(index=READERS)
    def reader_dies(self, index: int) -> None:
        """With all that share its datagrams: their process dies, and was sent the end for all or for none."""
        mates = tuple(self.processes[index]) if index < len(self.readers) else ()
        if self.writer is not None and self.over and any(map(self.has_the_end, mates)):
            self.informed.update(mates)
        for mate in mates:
            found = self.reader(mate)
            if found is not None:
                found.close()
                self.readers[mate] = None
                self.kept[mate].clear()
                self.dead.add(mate)
            self.processes[mate] = {mate}

    @precondition(lambda self: self.writer and None in self.readers)
    @rule(index=READERS)
    def reader_returns(self, index: int) -> None:
        """Whether or not the writer noticed that the one before died; it is awake and looks for credit."""
        if index >= len(self.readers) or self.readers[index] is not None:
            return
        assert self.writer is not None
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.writer.replace(index, ours)
        together = set(self.together[index])
        found_dead = together if index == min(together) else {index}
        self.mourn(i for i in found_dead if self.port.readers[i] is not None)
        for mate in found_dead:
            self.port.readers[mate] = None
            self.part(mate)
        self.welcome(index, theirs)
        self.asleep = False

    @precondition(lambda self: self.writer and any(self.readers))
    @rule(index=READERS, noticed=st.booleans())
    def reader_is_started_again(self, index: int, noticed: bool) -> None:
        self.reader_dies(index)
        if noticed:
            self.drain()
        self.reader_returns(index)

    @precondition(lambda self: self.writer)
    @rule()
    def writer_dies(self) -> None:
        """What is in the sockets is still read; what waits for room is gone."""
        assert self.writer is not None
        waits = not self.writer.flush()
        self.writer.close()
        self.writer = None
        self.sent.clear()
        self.loans.clear()
        self.asleep = False
        for index, found in enumerate(self.readers):
            owed = self.port.readers[index]
            while found is not None and not found.broken:
                self.take(index, found)
            if found is not None and owed is not None:
                assert waits or owed.satisfied, f"reader {index}: {owed}"
                assert found.lost is not owed.ended
                assert self.readable(found.fileno()), "a dead writer must wake its readers"

    @precondition(lambda self: not self.writer)
    @rule()
    def writer_returns(self) -> None:
        """It begins with all those that are there; the others return later."""
        pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in self.readers]
        away = {index for index, found in enumerate(self.readers) if found is None}
        homes = (
            [] if self.number else [ReaderLocation(self.homes[index], index) for index in range(len(pairs))]
        )
        self.together = [
            {i} | {h.edge for h in homes if h.worker == self.homes[i]} for i, _ in enumerate(pairs)
        ]
        self.processes = [set(mates) for mates in self.together]
        self.writer = RingWriter([ours for ours, _ in pairs], self.port.depth, homes)
        self.over = False
        self.reign = self.number
        self.informed.clear()
        for index, (_, theirs) in enumerate(pairs):
            self.port.readers[index] = Owed()
            if index in away and self.number:
                theirs.close()
                self.dead.add(index)
            else:
                if (found := self.readers[index]) is not None:
                    found.close()
                self.welcome(index, theirs)

    # What must hold at any time.

    @invariant()
    def only_the_dead_are_lost(self) -> None:
        if self.writer is not None:
            assert self.writer.lost <= self.dead - self.informed
            assert not any(found.lost for found in self.readers if found is not None)

    def teardown(self) -> None:
        """At the end each reader has all, and the writer all its credit."""
        try:
            if self.writer is not None:
                self.come_to_rest()
                self.end_it()
                self.writer_dies()
        finally:
            self.close()
        if sys.exception() is None:  # whose frames would keep the writer's memory
            assert open_descriptors() <= self.descriptors, "descriptors are left open"

    @precondition(lambda self: self.writer)
    @rule()
    def come_to_rest(self) -> None:
        """Each end acts when it is woken, and at no other time: all comes, and all credit is there again."""
        assert self.writer is not None
        self.turn_until_all_sleep()
        for index, found in enumerate(self.readers):
            owed = self.port.readers[index]
            if found is not None and owed is not None:
                assert owed.satisfied, f"reader {index} waits for ever for {owed}"
        assert self.writer.flush()
        self.loans.clear()
        self.sent.clear()
        for index, owed in enumerate(self.port.readers):
            self.forget(index, len(self.kept[index]))
            if owed is not None and self.readers[index] is not None:
                self.consume(index, owed.got - owed.consumed, forget=False)
        self.drain()
        assert self.writer.credit() == self.port.depth, "credit is lost"

    def end_it(self) -> None:
        """The end comes to every reader."""
        assert self.writer is not None
        if not self.over:
            self.end(3)
        self.turn_until_all_sleep()
        assert self.writer.flush()
        assert all(
            owed.ended
            for owed, found in zip(self.port.readers, self.readers, strict=True)
            if found is not None and owed is not None
        )


class TestRing(RingEdge.TestCase):
    settings = settings(
        max_examples=50,
        stateful_step_count=50,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )


@pytest.mark.thorough
class TestRingManyTimes(RingEdge.TestCase):
    settings = settings(
        max_examples=3_000,
        stateful_step_count=100,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )
