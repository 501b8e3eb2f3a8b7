"""Senders that come in the place of others, readers that come back: nothing is lost, nobody is stuck."""

from __future__ import annotations

import socket

from followspot import Context, Message, Stage
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import ABSENT, END, Watermark
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.ledger import UNMATCHED, Ledger
from followspot.worker.output_port import OutputPort
from followspot.worker.pace import Pace
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler

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
        self.queue = InputQueue("count -> save", self.ledger.words, 0, depth=DEPTH, lateness=0)
        ours, theirs = pair()
        self.writer = RingWriter([ours], DEPTH)
        self.queue.reader = RingReader(theirs, Note)
        join = Join([JoinInput("note", joined=False, members=(self.queue,))], lateness=0)
        self.runner = StageRunner("save", 0, lambda: Save(Context()), join, {})
        self.scheduler = Scheduler([self.runner], [self.queue], [], Pace())
        self.queue.wake = lambda: self.scheduler.schedule.mark(0)

    def replace_writer(self) -> None:
        """The writer dies, and another takes its place."""
        self.writer.close()
        ours, theirs = pair()
        self.writer = RingWriter([ours], DEPTH)
        assert self.queue.reader is not None
        self.scheduler.ends.adopt_reader(self.queue.reader, RingReader(theirs, Note))

    def work(self) -> None:
        self.scheduler.ends.receive(0)
        self.runner.step()


def test_all_that_a_sender_had_sent_is_taken_over_however_much_it_is() -> None:
    """More than a reader takes at a time: the rest was lost when another sender came before the next look."""
    reading = Reading()
    for watermark in range(260):
        reading.writer.send(Watermark(watermark))
    reading.writer.send(note(100))
    assert reading.writer.flush()
    reading.replace_writer()
    assert [message.header.seq for message in reading.queue.messages] == [100]


def test_a_sender_that_is_started_again_after_its_end_is_not_held_up_by_a_stage_that_has_ended() -> None:
    reading = Reading()
    reading.writer.send(Watermark(END))
    reading.work()
    assert reading.runner.done
    reading.replace_writer()
    reading.work()
    for number in range(3 * DEPTH):
        assert reading.writer.credit() > 0
        reading.writer.send(note(number))
        reading.work()
    assert reading.ledger.words[UNMATCHED] == 3 * DEPTH, "they have no match"
    reading.writer.send(Watermark(END))
    reading.work()
    assert reading.queue.watermark == END


def test_a_port_that_is_absent_stays_so_for_all_when_one_of_its_readers_comes_back() -> None:
    """The others went on to wait for it, and so did the one that came back, a feedback edge for ever."""
    ledger = Ledger(2)
    output = OutputPort(Note, ledger.words, lateness=0)
    (ours, near), (mine, theirs) = pair(), pair()
    ring = RingWriter([ours, mine], DEPTH)
    output.attach(ring, ["left", "right"], [ledger.row(0), ledger.row(1)])
    stays, returns = (InputQueue("", ledger.words, ledger.row(n), depth=DEPTH, lateness=0) for n in range(2))
    stays.reader, gone = RingReader(near, Note), RingReader(theirs, Note)
    output.send(Note(1), Header("count", 0, 5))
    output.absent()
    gone.close()
    ring.drain()
    output.update_readers()
    again, last = pair()
    ring.replace(1, again)
    output.update_readers()
    returns.reader = RingReader(last, Note)
    stays.poll()
    returns.poll()
    assert (stays.watermark, returns.watermark) == (ABSENT, ABSENT)
    output.send(Note(2), Header("count", 1, 7))
    stays.poll()
    returns.poll()
    assert (stays.watermark, returns.watermark) == (8, 8)
