"""Edges over Zenoh keep what an edge promises, in whatever order ends send, die, return and are cut off."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule
from tests.promises.edge_messages import SMALL, picture
from tests.promises.edge_model import ABSENT, END, Advance, Spoken
from tests.promises.zenoh_ends import TIMEOUT, ZenohEnds, readable
from tests.promises.zenoh_faults import ZenohFaults
from tests.promises.zenoh_hosts import READERS

from followspot.transport.token import UNKNOWN, Watermark


class ZenohEdge(ZenohFaults):
    """A port with two readers, over the sessions of hosts that examples share."""

    @initialize(depth=st.sampled_from([1, 3]))
    def begin(self, depth: int) -> None:
        self.set_up(depth)
        self.writer_returns(0)
        for index in range(READERS):
            self.reader_returns(index)
        self.until(self.matched)
        for owed in self.owed:
            owed.joins = False

    # What the writer does.

    @precondition(lambda self: self.speaks)
    @rule(size=st.sampled_from([SMALL, 40_000]), count=st.integers(1, 3), known=st.booleans())
    def send(self, size: int, count: int, known: bool = False) -> None:
        """known: the watermark after each message goes with it."""
        assert self.writer is not None
        for _ in range(count):
            if self.writer.credit():
                self.time += 10
                spoken = Spoken(self.number, self.time)
                self.number += 1
                self.say(spoken)
                message = picture(spoken, size)
                if known:
                    self.time += 7
                    self.say(Advance(self.time))
                self.writer.send(message, self.time if known else UNKNOWN)

    @precondition(lambda self: self.speaks)
    @rule(times=st.sampled_from([1, 1, 2, 300]))
    def advance(self, times: int) -> None:
        """More than may be under way, or a few."""
        assert self.writer is not None
        for _ in range(times):
            self.time += 10
            self.say(Advance(self.time))
            self.writer.send(Watermark(self.time))

    @precondition(lambda self: self.speaks)
    @rule()
    def be_absent(self) -> None:
        assert self.writer is not None
        if not self.silent:
            self.say(Advance(ABSENT))
            self.writer.send(Watermark(ABSENT))

    @precondition(lambda self: self.speaks)
    @rule(really=st.integers(0, 7))
    def end(self, really: int) -> None:
        assert self.writer is not None
        if really == 7:
            self.over = True
            self.announced.add(END)
            for owed in self.owed:  # readers that are there or come back are told
                owed.say(Advance(END))
            self.writer.send(Watermark(END))

    def flush(self) -> None:
        assert self.writer is not None
        self.writer.flush()

    @precondition(lambda self: self.speaks)
    @rule()
    def sleep(self) -> None:
        assert self.writer is not None
        self.drain()
        self.writer.want_credit()
        self.asleep = not self.writer.credit()

    @rule(index=st.integers(0, 1), count=st.integers(1, 4), what=st.sampled_from(["read", "consume", "look"]))
    def act(self, index: int, count: int, what: str) -> None:
        """An end acts, whether or not there is a reason."""
        if what == "read":
            self.read(index)
        elif what == "consume":
            self.consume(index, count)
        elif self.writer is not None:
            self.drain()
            self.flush()
            self.replaced_ends_act()

    # What readers do.

    def consume(self, index: int, count: int) -> None:
        reader = self.readers[index]
        for _ in range(min(count, len(self.taken[index]))):
            self.taken[index].popleft().consume()
            if reader is not None:
                reader.consumed()

    @precondition(lambda self: self.writer and not self.apart and not self.replaced)
    @rule(index=st.integers(0, 1))
    def catch_up(self, index: int) -> None:
        """Everything that was said arrives, whatever else is going on."""
        if self.readers[index] is not None:
            self.until(lambda: self.satisfied(index))

    @precondition(lambda self: self.speaks and not self.apart)
    @rule(count=st.integers(4, 12), size=st.sampled_from([SMALL, 40_000]))
    def flow(self, count: int, size: int) -> None:
        """As in a run: the writer sleeps without credit, and readers give it."""
        for _ in range(count):
            self.until(lambda: self.credit_after_reading() > 0)
            self.credit_is_no_more_than_readers_have_given()
            self.send(size, 1)

    @precondition(lambda self: self.writer and not self.replaced)
    @rule(index=st.integers(0, 1), with_host=st.booleans(), noticed=st.booleans())
    def reader_is_started_again(self, index: int, with_host: bool, noticed: bool) -> None:
        self.reader_dies(index, with_host)
        if noticed and not self.over and not self.apart:
            self.until(lambda: index in self.writer_lost)
        self.reader_returns(index)

    @precondition(lambda self: self.speaks and not self.apart)
    @rule(held=st.booleans(), lost=st.booleans(), count=st.integers(0, 3))
    def link_blinks(self, held: bool, lost: bool, count: int) -> None:
        self.cut(held)
        self.send(SMALL, count)
        self.mend(lost)

    # What must hold at any time.

    @invariant()
    def credit_is_no_more_than_readers_have_given(self) -> None:
        if self.writer is not None and self.speaks:
            strict = [
                owed.waiting
                for index, owed in enumerate(self.owed)
                if not (index in self.writer.lost or owed.joins or owed.leaks)
            ]
            assert self.writer.credit() <= max(0, self.depth - max(strict, default=0))

    @invariant()
    def credit_wakes_a_writer_that_sleeps(self) -> None:
        if self.asleep and self.writer is not None and self.writer.credit():
            assert readable(self.writer.filenos(), TIMEOUT), "there is credit, and the writer is not woken"
            self.asleep = False

    def teardown(self) -> None:
        try:
            if sys.exception() is None:
                self.come_to_rest()
                self.end_it()
                self.reader_is_started_again(0, with_host=False, noticed=False)
                self.end_it()
        finally:
            self.close()
            if sys.exception() is not None:  # the next example must not suffer from this one
                self.hosts.close()
                ZenohEnds.shared_hosts = None

    @rule()
    def come_to_rest(self) -> None:
        """Cables are mended and ends return: every message comes, and all credit is there again."""
        while self.replaced:
            self.replaced_end_leaves()
        if self.apart:
            self.mend(lost=False)
        if self.writer is None:
            self.writer_returns(self.writer_host)
        for index in range(READERS):
            self.reader_returns(index)
        self.until(lambda: self.all_joined)
        self.until(lambda: all(map(self.satisfied, range(READERS))))
        self.until(lambda: self.credit_after_reading() == self.depth)
        self.until(lambda: not any(reader.lost for reader in self.readers if reader is not None))
        for owed in self.owed:
            owed.rest()

    def end_it(self) -> None:
        """The end comes to every reader, and the writer knows."""
        if not self.over:
            self.end(7)
        self.until(lambda: self.all_joined)
        self.until(lambda: self.writer is not None and self.writer.flush() and not self.writer_lost)
        assert all(eras[0].ended for eras in self.eras), "the writer believes that they have the end"

    def credit_after_reading(self) -> int:
        assert self.writer is not None
        for index in range(READERS):
            self.consume(index, len(self.taken[index]))
        self.credit_wakes_a_writer_that_sleeps()
        self.writer.want_credit()
        self.asleep = not self.writer.credit()
        return self.writer.credit()


@pytest.fixture(scope="module", autouse=True)
def hosts() -> Iterator[None]:
    """A process whose sessions are open does not exit."""
    yield
    if ZenohEnds.shared_hosts is not None:
        ZenohEnds.shared_hosts.close()


class TestZenoh(ZenohEdge.TestCase):
    settings = settings(
        max_examples=12,
        stateful_step_count=20,
        deadline=None,
        phases=[Phase.generate],  # the network is not the same twice, and a failure takes its time
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )


@pytest.mark.thorough
class TestZenohManyTimes(ZenohEdge.TestCase):
    settings = settings(TestZenoh.settings, max_examples=400, stateful_step_count=40)
