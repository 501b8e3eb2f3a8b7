"""Whatever happens to the ends of a port, the ledger counts each message, and no end waits for ever."""

from __future__ import annotations

import socket
from collections import deque

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule
from tests.promises.edge_messages import SMALL, Picture, header, intact, picture
from tests.promises.edge_model import ABSENT, END, Spoken
from tests.promises.port_ends import (
    AHEAD,
    ANY,
    ANY_FAR,
    EDGES,
    FAR,
    LATENESS,
    LEFT,
    LOOSE,
    NEAR,
    PAIR,
    RIGHT,
    ROUNDS,
    SIZES,
    Count,
    PortEnds,
    Reader,
    readable,
)

from followspot import Context
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import UNKNOWN
from followspot.worker.inputs.join import Join
from followspot.worker.ledger import DROPPED, LATE, UNMATCHED
from followspot.worker.output_port import OutputPort
from followspot.worker.pace import Pace
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler


class PortOfRun(PortEnds):
    """The ends of a port send, read, die and return in any order."""

    @initialize(depth=st.sampled_from([1, 2, 4]), live=st.booleans())
    def begin(self, depth: int, live: bool) -> None:
        self.set_up(depth, live)
        self.sender_begins()

    # The sender.

    @precondition(lambda self: self.speaks and self.output.has_room())
    @rule(size=SIZES, count=st.integers(1, 6), known=st.booleans())
    def produce(self, size: int, count: int, known: bool = False) -> None:
        """known: the watermark after each message goes with it."""
        for _ in range(count):
            if self.output.has_room():
                self.time += 10
                spoken = Spoken(self.number, self.time)
                self.number += 1
                self.expect(spoken)
                self.announced = self.time + (9 if known else 1 + LATENESS)
                following = self.announced if known else UNKNOWN
                self.output.send(picture(spoken, size), header(spoken), following)

    @precondition(lambda self: self.speaks and self.output.has_room())
    @rule()
    def produce_what_is_refused(self) -> None:
        """It lies before the watermark, so no reader gets it."""
        self.time += 10
        self.output.advance(self.time + 5)
        self.produced += 1
        self.output.send(picture(Spoken(-1, self.time), SMALL), header(Spoken(-1, self.time)))
        self.announced = self.time = self.time + 5

    @precondition(lambda self: self.speaks)
    @rule(times=st.sampled_from([1, 1, 260, 400]))
    def advance(self, times: int) -> None:
        for _ in range(times):
            self.time += 10
            self.output.advance(self.time)
        self.announced = self.time if times else self.announced

    @precondition(lambda self: self.speaks and self.live)
    @rule()
    def be_absent(self) -> None:
        self.output.absent()
        self.announced = ABSENT

    @precondition(lambda self: self.speaks)
    @rule(really=st.integers(0, 5))
    def end(self, really: int) -> None:
        if really == 5:
            self.output.end()
            self.announced = END
            self.over = self.ended_once = True

    @precondition(lambda self: self.sender)
    @rule()
    def sender_looks(self) -> None:
        """The sender's worker sees to whatever wakes it."""
        assert self.sender is not None
        self.sender.ends.receive(0)

    # The readers.

    @rule(edge=ANY_FAR)
    def reader_looks(self, edge: int) -> None:
        reader = self.readers.get(edge)
        if reader is not None:
            before = len(reader.queue.messages), reader.queue.watermark
            reader.scheduler.ends.receive(0)
            self.check_arrivals(edge, *before)

    @rule(edge=ANY, count=st.integers(1, 4))
    def take(self, edge: int, count: int) -> None:
        """A firing takes messages."""
        reader = self.readers.get(edge)
        if reader is not None:
            for _ in range(min(count, len(reader.queue.messages))):
                assert intact(reader.queue.take())
                self.accounted[edge] += 1

    @rule(edge=ANY, count=st.integers(1, 4), column=st.sampled_from([DROPPED, LATE, UNMATCHED]))
    def throw_away(self, edge: int, count: int, column: int) -> None:
        reader = self.readers.get(edge)
        if reader is not None:
            for _ in range(min(count, len(reader.queue.messages))):
                reader.queue.discard(column)
                self.accounted[edge] += 1

    # Deaths and returns.

    @rule(edge=ANY_FAR)
    def reader_dies(self, edge: int) -> None:
        """With what it had in its queue."""
        reader = self.readers.pop(edge, None)
        if reader is not None:
            self.unheard = reader.owed if edge == LOOSE else self.unheard
            self.astray[edge] += reader.queue.uncredited  # of which this sender knows nothing
            reader.scheduler.close()

    @precondition(lambda self: self.sender and len(self.readers) < len(EDGES))
    @rule(edge=ANY_FAR)
    def reader_returns(self, edge: int) -> None:
        """Whether or not the sender has noticed that the one before died."""
        if edge in self.readers:
            return
        assert self.sender is not None
        ours, theirs = socket.socketpair(*PAIR)
        writer, index = self.writers[edge]
        writer.replace(index, ours)
        self.readers[edge] = self.reader(edge, theirs)
        self.sender.ends.adopt_link(writer, ours.fileno())

    @precondition(lambda self: self.sender)
    @rule(heard=st.booleans())
    def sender_dies(self, heard: bool) -> None:
        """With what it had in hand, and with the stage that reads in its worker.

        heard: whether the others read what is left before the next one begins.
        """
        assert self.sender is not None
        del self.readers[NEAR]
        self.left_all = self.writers[LEFT][0].flush()
        self.sender.close()
        self.sender = None
        for edge, reader in self.readers.items() if heard else ():
            while readable(reader.scheduler):
                self.reader_looks(edge)
            assert reader.queue.watermark in (END, ABSENT) or not self.live, (
                "no end tells that the sender is away"
            )

    @precondition(lambda self: not self.sender)
    @rule()
    def sender_begins(self) -> None:
        """Another one, with rings to the readers that are present; the others come back later."""
        pairs = {edge: socket.socketpair(*PAIR) for edge in FAR}
        self.output = OutputPort(Picture, self.ledger.words, lateness=LATENESS)
        self.output.waits_for_readers = not self.live
        near = self.queue(NEAR)
        self.output.connect([near])
        ring = RingWriter([pairs[LEFT][0], pairs[RIGHT][0]], self.depth)
        loose = DroppingWriter(RingWriter([pairs[LOOSE][0]], AHEAD), self.depth)
        self.writers = {LEFT: (ring, 0), RIGHT: (ring, 1), LOOSE: (loose, 0)}
        self.output.attach(ring, ["left", "right"], [self.ledger.row(LEFT), self.ledger.row(RIGHT)])
        self.output.attach(loose, ["loose"], [self.ledger.row(LOOSE)])
        join = Join((), lateness=LATENESS)
        runner = StageRunner("count", 0, lambda: Count(Context()), join, {"out": self.output})
        self.sender = Scheduler([runner], [], [(ring, runner), (loose, runner)], Pace())
        first = not self.number and not self.produced
        self.over, self.announced = False, -END
        self.unheard = deque()
        self.readers[NEAR] = Reader(near, self.sender)
        for edge, (_, theirs) in pairs.items():
            if edge in self.readers:
                self.adopt(edge, theirs)
            elif first:
                self.readers[edge] = self.reader(edge, theirs)
            else:
                theirs.close()
        self.astray = [self.count(edge).in_flight - self.queued(edge) for edge in EDGES]

    @precondition(lambda self: self.speaks)
    @rule(times=st.sampled_from([0, 1, 260]))
    def sender_is_started_again_while_no_reader_reads(self, times: int) -> None:
        """What it had sent is longer than readers take at a time."""
        self.advance(times)
        if self.output.has_room():
            self.produce(SMALL, 2)
        self.sender_dies(heard=False)
        self.sender_begins()

    # What must hold at any time.

    @invariant()
    def every_message_is_in_one_column(self) -> None:
        for edge in EDGES:
            count = self.count(edge)
            parts = count.delivered, count.dropped, count.late, count.unmatched, count.invalid, count.lost
            assert min(vars(count).values()) >= 0, count
            assert count.surplus == 0, count
            assert count.produced == self.produced == count.sent + count.away
            assert count.sent == sum(parts) + count.in_flight
            taken = count.delivered + count.late + count.unmatched
            assert taken <= self.accounted[edge] <= taken + count.dropped

    @invariant()
    def no_queue_is_longer_than_its_edge_is_deep(self) -> None:
        for reader in self.readers.values():
            assert len(reader.queue.messages) - reader.queue.uncredited <= max(self.depth, AHEAD)

    def teardown(self) -> None:
        try:
            if self.sender is None:
                self.sender_begins()
            for edge in FAR:
                self.reader_returns(edge)
            self.come_to_rest()
            if not self.over:
                self.end(5)
            self.come_to_rest()
            assert all(writer.flush() for writer, _ in self.writers.values())
        finally:
            for scheduler in {self.sender, *(reader.scheduler for reader in self.readers.values())} - {None}:
                scheduler.close()

    @precondition(lambda self: self.sender)
    @rule()
    def come_to_rest(self) -> None:
        """All act when woken, and at no other time, until all have what they are owed."""
        assert self.sender is not None
        for edge in self.readers:
            self.take(edge, ROUNDS)
        for _ in range(ROUNDS):
            woken = [edge for edge in FAR if edge in self.readers and readable(self.readers[edge].scheduler)]
            if not woken and not readable(self.sender):
                break
            self.sender_looks()
            for edge in woken:
                self.reader_looks(edge)
                self.take(edge, ROUNDS)
        else:
            raise AssertionError("an end is woken again and again for nothing")
        for edge in EDGES:
            assert self.count(edge).in_flight == self.astray[edge], f"{edge}: {self.count(edge)}"
        for edge, reader in self.readers.items():
            assert edge == LOOSE or not reader.owed, f"edge {edge} waits for ever for {reader.owed}"
            known = self.announced in (-END, reader.queue.watermark)
            assert known or (reader.over and reader.queue.watermark == END), (
                f"edge {edge} does not know {self.announced}"
            )
        assert self.over or self.output.has_room() or self.output.waits_for_readers


class TestPort(PortOfRun.TestCase):
    settings = settings(
        max_examples=60,
        stateful_step_count=50,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )


@pytest.mark.thorough
class TestPortManyTimes(PortOfRun.TestCase):
    settings = settings(TestPort.settings, max_examples=3_000, stateful_step_count=100)
