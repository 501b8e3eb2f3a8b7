"""The writing end of an edge that drops: always room, the newest kept, every message accounted for."""

from __future__ import annotations

import socket

from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, stamped
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Watermark


class Note(Message):
    text: str


class Bench:
    """A writer that keeps a few messages, with two on their way to its reader, and counts what it drops."""

    def __init__(self, depth: int) -> None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.writer = DroppingWriter(RingWriter([ours], 2), depth)
        self.reader = RingReader(theirs, Note)
        self.dropped = 0
        self.refused: list[str] = []
        self.writer.dropped = self.drop
        self.writer.refused = self.refused.append

    def drop(self) -> None:
        self.dropped += 1

    def send(self, *numbers: int, text: str = "") -> None:
        for number in numbers:
            note = Note(text or str(number))
            self.writer.send(stamped(note, Header("a", number, 10 * number)))

    def take(self) -> list[str | int]:
        """Read everything, and let the writer send what it kept, until nothing more comes."""
        read: list[str | int] = []
        while tokens := self.reader.poll():
            for token in tokens:
                if isinstance(token, Note):
                    read.append(token.text)
                    self.reader.consumed()
                elif isinstance(token, Watermark):
                    read.append(token.time)
            self.writer.drain()
        return read


def test_there_is_always_room_and_the_newest_messages_are_kept() -> None:
    bench = Bench(depth=3)
    bench.send(*range(20))
    assert bench.writer.credit() > 0
    assert bench.take() == ["0", "1", "17", "18", "19"]
    assert bench.dropped == 15


def test_a_reader_that_keeps_up_gets_everything() -> None:
    bench = Bench(depth=1)
    read = []
    for number in range(20):
        bench.send(number)
        read += bench.take()
    assert read == [str(number) for number in range(20)]
    assert bench.dropped == 0


def test_watermarks_keep_their_place_and_the_end_comes_last() -> None:
    bench = Bench(depth=1)
    bench.send(0, 1, 2)
    bench.writer.send(Watermark(25))
    bench.send(3)
    bench.writer.send(Watermark(35))
    bench.writer.send(Watermark(END))
    assert not bench.writer.flush()
    assert bench.take() == ["0", "1", 25, "3", END]
    assert bench.dropped == 1
    assert bench.writer.flush()


def test_what_waits_for_a_reader_that_dies_is_dropped_and_another_takes_its_place() -> None:
    bench = Bench(depth=2)
    bench.send(*range(4))
    bench.reader.close()
    bench.writer.drain()
    assert bench.writer.lost == {0}
    assert bench.dropped == 2
    bench.send(4)
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    bench.writer.replace(0, ours)
    bench.reader = RingReader(theirs, Note)
    bench.send(5)
    assert bench.take() == ["5"]


def test_a_message_that_cannot_travel_is_refused_when_its_turn_comes() -> None:
    bench = Bench(depth=2)
    bench.send(0, 1)
    bench.send(2, text="x" * 100_000)
    bench.send(3)
    assert bench.take() == ["0", "1", "3"]
    assert len(bench.refused) == 1


def test_a_watermark_waits_with_its_message_and_outlives_it() -> None:
    bench = Bench(depth=2)
    for number in range(6):
        note = stamped(seal(Note(str(number))), Header("a", number, 10 * number))
        bench.writer.send(note, 10 * number + 5)
    assert bench.take() == ["0", 5, "1", 15, 25, 35, "4", 45, "5", 55]
    assert bench.dropped == 2


def test_a_watermark_comes_though_its_message_cannot_travel() -> None:
    bench = Bench(depth=3)
    note = stamped(Note("x" * 100_000), Header("a", 0, 0))
    bench.writer.send(note, 5)
    assert bench.take() == [5]
    assert len(bench.refused) == 1
