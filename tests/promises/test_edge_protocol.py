"""A ring keeps what an edge promises, in whatever order its ends send, read, sleep, die and return."""

from __future__ import annotations

import socket
import sys

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule
from tests.promises.edge_model import ABSENT, END, Advance, Owed, Spoken
from tests.promises.edge_words import SMALL, intact, picture
from tests.promises.ring_ends import RingEnds, open_descriptors

from followspot.transport.ring.links import ReaderLocation
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import UNKNOWN, Watermark

READERS = st.integers(0, 2)
SIZES = st.sampled_from([SMALL, 5_000, 5_000, 9_000, 40_000])
"""In the datagram, in a slot, and in slots that are larger than those before."""
HOMES = ["abc", "aab", "aba", "aaa"]
HOARDS = st.sets(READERS)
FEW = st.integers(1, 4)


class RingEdge(RingEnds):
    """A port with three readers; each end is moved by what its descriptors say, and at odd times."""

    @initialize(readers=st.integers(1, 3), depth=st.sampled_from([1, 2, 4]), homes=st.sampled_from(HOMES))
    def begin(self, readers: int, depth: int, homes: str) -> None:
        """homes: the process of each reader; those of one process share datagrams at first."""
        self.set_up(readers, depth)
        self.homes = homes
        self.writer_returns()

    # What the writer does.

    @precondition(lambda self: self.speaks and self.writer.credit())
    @rule(size=SIZES, lent=st.booleans(), keeps=st.booleans(), wastes=st.booleans(), known=st.booleans())
    def send(self, size: int, lent: bool, keeps: bool, wastes: bool = False, known: bool = False) -> None:
        """With credit; that an array is lent, which the stage uses or not, does not take it.

        known: the watermark after the message goes with it.
        """
        assert self.writer is not None
        self.time += 10
        if wastes:
            self.lend(size)
        loan = self.writer.loan((size,), "u1") if lent else None
        spoken = Spoken(self.number, self.time, slot=size > SMALL)
        message = picture(spoken, size, loan)
        self.time += 7 * known
        self.writer.send(message, self.time if known else UNKNOWN)
        self.number += 1
        self.say(spoken)
        if known:
            self.say(Advance(self.time))
        if keeps:
            self.sent.append(message)

    @precondition(lambda self: self.speaks)
    @rule(size=SIZES, count=st.sampled_from([1, 2, 9]))
    def borrow(self, size: int, count: int) -> None:
        """A stage takes arrays and does not send them yet, or never."""
        assert self.writer is not None
        self.asleep = False
        before = self.writer.credit()
        for _ in range(count):
            self.lend(size)
        assert self.writer.credit() > 0 or before == 0
        self.give_back(0)

    @precondition(lambda self: self.loans)
    @rule(count=FEW)
    def give_back(self, count: int) -> None:
        self.asleep = False
        assert all((loan == 255).all() for loan in self.loans), "another one wrote there"
        del self.loans[:count]

    @precondition(lambda self: self.sent)
    @rule(count=FEW)
    def forget_sent(self, count: int) -> None:
        self.asleep = False
        assert all(map(intact, self.sent))
        del self.sent[: max(0, count)]

    @precondition(lambda self: self.speaks)
    @rule(times=st.sampled_from([1, 1, 2]))
    def advance(self, times: int) -> None:
        assert self.writer is not None
        for _ in range(times):
            self.time += 10
            self.writer.send(Watermark(self.time))
            self.say(Advance(self.time))

    @precondition(lambda self: self.speaks)
    @rule(messages=st.integers(0, 2))
    def flood(self, messages: int) -> None:
        """More than fits into any socket; what must wait is merged, but for messages."""
        assert self.writer is not None
        self.advance(400)
        for _ in range(messages):
            if self.writer.credit():
                self.send(SMALL, lent=False, keeps=False)
                self.advance(2)

    @precondition(lambda self: self.speaks and not self.silent)
    @rule()
    def be_absent(self) -> None:
        assert self.writer is not None
        self.writer.send(Watermark(ABSENT))
        self.say(Advance(ABSENT))

    @precondition(lambda self: self.speaks)
    @rule(really=st.integers(0, 3))
    def end(self, really: int) -> None:
        if really == 3:
            assert self.writer is not None
            self.writer.send(Watermark(END))
            self.say(Advance(END))
            self.over = True

    @precondition(lambda self: self.writer)
    @rule()
    def drain(self) -> None:
        """Whether or not there was anything to wake it."""
        assert self.writer is not None
        self.writer.drain()
        self.notice()

    @precondition(lambda self: self.writer)
    @rule()
    def flush(self) -> None:
        assert self.writer is not None
        self.writer.flush()

    @precondition(lambda self: self.speaks and not self.writer.credit())
    @rule()
    def sleep(self) -> None:
        """Until there is credit: from now on it must be woken by that."""
        assert self.writer is not None
        self.drain()
        self.writer.want_credit()
        self.asleep = not self.writer.credit()

    @precondition(lambda self: self.speaks)
    @rule(size=SIZES, lent=st.booleans(), keeps=st.booleans())
    def burst(self, size: int, lent: bool, keeps: bool) -> None:
        """As many as there is credit for, without asking again; one more is a mistake."""
        assert self.writer is not None
        for _ in range(self.writer.credit()):
            self.send(size, lent, keeps)
        if not self.port.credit:
            with pytest.raises(RuntimeError, match="credit"):
                self.writer.send(picture(Spoken(self.number, self.time + 10), SMALL))

    @precondition(lambda self: self.speaks and any(self.readers))
    @rule(count=st.integers(5, 40), size=SIZES, lent=st.booleans(), keeps=st.booleans(), hoards=HOARDS)
    def flow(self, count: int, size: int, lent: bool, keeps: bool, hoards: set[int]) -> None:
        """Many messages, as a run sends them; some readers keep every third, the others let go."""
        assert self.writer is not None
        for _ in range(count):
            while not self.writer.credit():
                self.sleep()  # which finds the dead, and may give their credit back
                assert self.all_read(hoards) or self.writer.credit(), "all was taken, and there is no credit"
                self.credit_wakes_a_writer_that_sleeps()
            self.credit_is_what_the_readers_have_given()
            self.send(size, lent, keeps)
            if keeps:
                self.forget_sent(len(self.sent) - 3)

    @precondition(lambda self: self.speaks and any(self.readers))
    @rule(size=SIZES, lets_go=READERS)
    def crowd(self, size: int, lets_go: int) -> None:
        """All readers hold their share, and the writer sends what it still can."""
        assert self.writer is not None
        self.borrow(size, count=9)
        self.flow(4 * self.port.depth + 4, size, lent=False, keeps=False, hoards={0, 1, 2})
        self.burst(size, lent=False, keeps=False)
        if not self.writer.credit():
            self.sleep()
            self.forget(lets_go, 2)
            self.credit_wakes_a_writer_that_sleeps()

    # What readers do.

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
    def credit_is_what_the_readers_have_given(self) -> None:
        if self.writer is None:
            return
        credit = self.writer.credit()
        lent = len(self.loans) + len(self.sent)
        assert credit <= self.port.credit
        if not self.dead:
            assert credit >= self.port.credit_of_memory(lent, [len(kept) for kept in self.kept])

    @invariant()
    def credit_wakes_a_writer_that_sleeps(self) -> None:
        if self.asleep and self.writer is not None and self.writer.credit():
            assert any(map(self.readable, self.writer.filenos())), (
                "there is credit, and the writer is not woken"
            )
            self.asleep = False

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
