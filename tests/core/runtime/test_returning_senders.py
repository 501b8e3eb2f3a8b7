"""Senders that come in the place of others, readers that come back: nothing is lost, nobody is stuck."""

from __future__ import annotations

import socket

from followspot import Context, Message, Stage
from followspot.messages import Header, seal, stamped
from followspot.runtime.cell import Cell
from followspot.runtime.firing import InputPort, Join
from followspot.runtime.inlet import Inlet
from followspot.runtime.ledger import UNMATCHED, Ledger
from followspot.runtime.outlet import Outlet
from followspot.runtime.pace import Pace
from followspot.runtime.worker import Worker
from followspot.transport.ring_reader import RingReader
from followspot.transport.ring_writer import RingWriter
from followspot.transport.token import ABSENT, END, Settled

DEPTH = 4


class Note(Message):
    number: int


class Save(Stage):
    """Reads notes."""

    def process(self, note: Note) -> None:
        pass


def pair() -> tuple[socket.socket, socket.socket]:
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def note(number: int) -> Note:
    return stamped(seal(Note(number)), Header("count", number, 10 * number))


class Reading:
    """A worker that reads one edge, and the writers that feed it one after the other."""

    def __init__(self) -> None:
        self.ledger = Ledger(1)
        self.inlet = Inlet("count -> save", self.ledger.words, 0, depth=DEPTH, slack=0)
        ours, theirs = pair()
        self.writer = RingWriter([ours], DEPTH)
        self.inlet.reader = RingReader(theirs, Note)
        join = Join([InputPort("note", joined=False, members=(self.inlet,))], window=0, slack=0)
        self.cell = Cell("save", 0, lambda: Save(Context()), join, {})
        self.worker = Worker([self.cell], [self.inlet], [], Pace())
        self.inlet.wake = lambda: self.worker.mark(0)

    def succeed(self) -> None:
        """The writer dies, and another takes its place."""
        self.writer.close()
        ours, theirs = pair()
        self.writer = RingWriter([ours], DEPTH)
        assert self.inlet.reader is not None
        self.worker.adopt_reader(self.inlet.reader, RingReader(theirs, Note))

    def work(self) -> None:
        self.worker._receive(0)
        self.cell.step()


def test_all_that_a_sender_had_sent_is_taken_over_however_much_it_is() -> None:
    """More than a reader takes at a time: the rest was lost when another sender came before the next look."""
    reading = Reading()
    for bound in range(260):
        reading.writer.send(Settled(bound))
    reading.writer.send(note(100))
    assert reading.writer.flush()
    reading.succeed()
    assert [message.header.seq for message in reading.inlet.queue] == [100]


def test_a_sender_that_is_started_again_after_its_end_is_not_held_up_by_a_stage_that_has_ended() -> None:
    reading = Reading()
    reading.writer.send(Settled(END))
    reading.work()
    assert reading.cell.done
    reading.succeed()
    reading.work()
    for number in range(3 * DEPTH):
        assert reading.writer.credit() > 0
        reading.writer.send(note(number))
        reading.work()
    assert reading.ledger.words[UNMATCHED] == 3 * DEPTH, "they have no match"
    reading.writer.send(Settled(END))
    reading.work()
    assert reading.inlet.bound == END


def test_a_port_that_is_absent_stays_so_for_all_when_one_of_its_readers_comes_back() -> None:
    """The others went on to wait for it, and so did the one that came back, a feedback edge for ever."""
    ledger = Ledger(2)
    outlet = Outlet(Note, ledger.words, slack=0)
    (ours, near), (mine, theirs) = pair(), pair()
    ring = RingWriter([ours, mine], DEPTH)
    outlet.attach(ring, ["left", "right"], [ledger.row(0), ledger.row(1)])
    stays, returns = (Inlet("", ledger.words, ledger.row(n), depth=DEPTH, slack=0) for n in range(2))
    stays.reader, gone = RingReader(near, Note), RingReader(theirs, Note)
    outlet.send(Note(1), Header("count", 0, 5))
    outlet.absent()
    gone.close()
    ring.drain()
    outlet.look()
    again, last = pair()
    ring.replace(1, again)
    outlet.look()
    returns.reader = RingReader(last, Note)
    stays.poll()
    returns.poll()
    assert (stays.bound, returns.bound) == (ABSENT, ABSENT)
    outlet.send(Note(2), Header("count", 1, 7))
    stays.poll()
    returns.poll()
    assert (stays.bound, returns.bound) == (8, 8)
