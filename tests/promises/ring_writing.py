"""What the writer of a ring does: send, lend arrays, sleep until there is credit, end."""

from __future__ import annotations

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import invariant, precondition, rule
from tests.promises.edge_messages import SMALL, intact, picture
from tests.promises.edge_model import ABSENT, END, Advance, Spoken
from tests.promises.ring_reading import FEW, READERS, ReadingRing

from followspot.transport.token import UNKNOWN, Watermark

SIZES = st.sampled_from([SMALL, 5_000, 5_000, 9_000, 40_000])
"""In the datagram, in a slot, and in slots that are larger than those before."""
HOARDS = st.sets(READERS)


class WritingRing(ReadingRing):
    """Rules of the writing end, and when it must have credit."""

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
