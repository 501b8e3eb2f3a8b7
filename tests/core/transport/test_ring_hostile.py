"""A ring whose other end says what no end says: well-formed datagrams and shared words with extreme values.

What cannot be meant is refused and counted, nothing of it is kept, and a good message still passes; a reader
that cannot be believed is cut off, and the others go on.
"""

from __future__ import annotations

import itertools
import mmap
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.core.transport.rings import DEPTH, Ring, frame, messages

from followspot.messages import Message, identical
from followspot.tracking import Frame
from followspot.transport.ring.control import ARENAS, CONSUMED, Control
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import (
    ARENA,
    HELLO,
    INLINE,
    MAX_SLOT,
    MAX_SLOTS,
    NOTIFICATION,
    SLOT,
    WATERMARK,
)
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import ABSENT, END, MAX_COUNT, MAX_WATERMARK, Token, Watermark

EXTREME = (2**63 - 1, -(2**63), -1, MAX_COUNT + 1)


class Hostile:
    """A writer, a reader, and the writer's socket, on which anything may be sent."""

    def __init__(self) -> None:
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.writer = RingWriter([self.socket], DEPTH)
        self.reader = RingReader(theirs, Frame)

    def say(self, *words: int, rest: bytes = b"", memory: int | None = None) -> None:
        """Send one datagram, perhaps with a descriptor; the reader gets it and gives nothing out."""
        datagram = NOTIFICATION.pack(*words) + rest
        if memory is None:
            self.socket.send(datagram)
        else:
            socket.send_fds(self.socket, [datagram], [memory])
        assert polled(self.reader) == []

    def alive(self, number: int = 0) -> Message:
        """A good message still passes, and so does its credit."""
        assert self.writer.credit()
        self.writer.send(frame(number))
        (message,) = messages(polled(self.reader))
        assert identical(message, frame(number))
        self.reader.consumed()
        assert self.writer.credit()
        return message

    def close(self) -> None:
        self.writer.close()
        self.reader.close()


@pytest.fixture
def ring() -> Iterator[Hostile]:
    made = Hostile()
    yield made
    made.close()


def polled(reader: RingReader) -> list[Token]:
    """Everything that is there; one look may leave the rest to the next."""
    return [token for _ in range(3) for token in reader.poll()]


def descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


@pytest.mark.parametrize("kind", [INLINE, SLOT])
@pytest.mark.parametrize("value", [*EXTREME, 300])
def test_numbers_of_messages_that_cannot_be_next_are_refused(ring: Hostile, kind: int, value: int) -> None:
    ring.alive()
    ring.say(kind, 0, 0, 0, value)
    assert ring.reader.rejected == 1
    ring.alive(1)


@pytest.mark.parametrize("time", [MAX_WATERMARK + 1, ABSENT - 1, -MAX_WATERMARK - 1, -(2**63)])
def test_bounds_that_no_message_leads_to_are_refused(ring: Hostile, time: int) -> None:
    ring.say(WATERMARK, 0, 0, 0, time)
    assert ring.reader.rejected == 1
    assert not ring.reader._ended
    ring.alive()


@pytest.mark.parametrize("time", [MAX_WATERMARK, -MAX_WATERMARK, ABSENT, END])
def test_bounds_that_can_be_meant_pass(ring: Hostile, time: int) -> None:
    ring.writer.send(Watermark(time))
    assert ring.reader.poll() == [Watermark(time)]


@pytest.mark.parametrize(
    "words",
    [
        (HELLO, 0, 1, 8, 0),  # a second greeting
        (ARENA, 0, 0, 0, mmap.PAGESIZE),  # an arena that is there already
        (ARENA, ARENAS, 0, 0, mmap.PAGESIZE),
        (ARENA, 255, 0, 0, mmap.PAGESIZE),
        *((ARENA, 1, 0, 0, size) for size in (0, -mmap.PAGESIZE, 100, 2 * MAX_SLOT, 2**62, -(2**63))),
        (ARENA, 1, 0, 0, MAX_SLOT),  # more than the memory that comes with it
        (0, 0, 0, 0, 0),
        (255, 255, 65535, 2**32 - 1, 2**63 - 1),
        (INLINE, 0, 0, 0, 1),  # nothing brings memory but the two that need it
        (WATERMARK, 0, 0, 0, 7),
    ],
)
def test_memory_that_no_writer_gives_is_refused_and_let_go_of(ring: Hostile, words: tuple[int, ...]) -> None:
    kept = ring.alive()
    memory = Memory.create("hostile", 64 * mmap.PAGESIZE)  # enough for an arena of the smallest slots
    before = descriptors()
    for count in range(1, 4):
        ring.say(*words, memory=memory.fd)
        assert ring.reader.rejected == count
    assert descriptors() == before
    ring.alive(1)
    assert kept is not None


@pytest.mark.parametrize(
    ("slots", "quota", "sequence"),
    [(0, 0, 0), (2**32 - 1, 1, 0), (MAX_SLOTS + 1, 1, 0), (8, 9, 0), (8, 1, -1), (8, 1, MAX_COUNT + 1)],
)
def test_a_greeting_that_no_writer_gives_is_refused(slots: int, quota: int, sequence: int) -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    reader = RingReader(theirs, Frame)
    memory = Memory.create("hostile", Control.size(8))
    socket.send_fds(ours, [NOTIFICATION.pack(HELLO, 0, quota, slots, sequence)], [memory.fd])
    assert reader.poll() == []
    assert reader.rejected == 1
    writer = RingWriter([ours], DEPTH)
    writer.send(frame(0))
    assert len(messages(polled(reader))) == 1
    writer.close()
    reader.close()


def test_descriptors_that_are_no_sealed_memory_are_refused_and_let_go_of(tmp_path: Path) -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    reader = RingReader(theirs, Frame)
    file = (tmp_path / "file").open("wb+")
    file.truncate(1 << 20)
    unsealed = os.memfd_create("unsealed", os.MFD_ALLOW_SEALING)
    os.ftruncate(unsealed, 1 << 20)
    pipe = os.pipe()
    before = descriptors()
    for count, fd in enumerate((file.fileno(), unsealed, pipe[0], ours.fileno()), 1):
        socket.send_fds(ours, [NOTIFICATION.pack(HELLO, 0, 1, 8, 0)], [fd])
        assert reader.poll() == []
        assert reader.rejected == count
    assert descriptors() == before
    file.close()
    for fd in (unsealed, *pipe):
        os.close(fd)
    ours.close()
    reader.close()


@pytest.mark.parametrize("consumed", [2, 2**63, 2**64 - 1])
def test_a_reader_that_consumed_more_than_was_sent_is_cut_off_and_the_others_go_on(consumed: int) -> None:
    with Ring(2) as ring:
        ring.writer.send(frame(0))
        liar, honest = ring.readers
        assert liar.poll()
        assert liar._memory.control is not None
        liar._memory.control.words[CONSUMED] = consumed
        ring.writer.credit()
        ring.writer.drain()
        assert ring.writer.lost == {0}
        assert ring.writer.rejected == 1
        assert honest.poll()
        honest.consumed()
        for number in range(1, 3 * DEPTH):
            assert ring.writer.credit()
            ring.writer.send(frame(number))
            assert identical(messages(honest.poll())[0], frame(number))
            honest.consumed()
        assert liar.poll() == []
        assert liar.lost


def test_a_reader_that_gives_credit_without_reading_fills_no_memory(ring: Hostile) -> None:
    assert ring.reader.poll() == []
    assert ring.reader._memory.control is not None
    limit = 100_000
    for number in range(limit):
        ring.reader._memory.control.words[CONSUMED] = number
        assert ring.writer.credit()
        ring.writer.send(small(number))
        if ring.writer.rejected:
            break
    (link,) = ring.writer._links.all
    assert ring.writer.rejected == 1, "the socket never was full"
    assert len(link._pending) < 100
    ring.writer.drain()
    assert ring.writer.lost == {0}


def test_a_reader_that_takes_its_releases_back_lets_no_slot_be_overwritten_that_another_one_keeps() -> None:
    with Ring(2) as ring:
        liar, honest = ring.readers
        ring.writer.send(frame(0))
        for reader in ring.readers:
            reader.consumed(len(reader.poll()))
        ring.writer.send(frame(1))
        (kept,) = messages(honest.poll())
        assert ring.writer.credit()
        assert liar._memory.control is not None
        liar._memory.control.release_all(0, [2**63] * ring.writer._slots)
        ring.writer.send(frame(2))
        assert [identical(m, frame(2)) for m in messages(honest.poll())] == [True]
        assert identical(kept, frame(1))


def test_wake_ups_without_end_do_not_hold_up_the_writer(ring: Hostile) -> None:
    ring.alive()
    wakes = flood(ring.reader)
    assert wakes > 256, "the flood is too small to show anything"
    ring.writer.drain()
    assert flood(ring.reader) < wakes, "one look swallowed them all"
    for _ in range(100):
        ring.writer.drain()
    ring.alive(1)
    assert not ring.writer.lost


def flood(reader: RingReader) -> int:
    """Send wake-ups until there is no room; how many."""
    for count in itertools.count():
        try:
            reader._socket.send(b"\1")
        except BlockingIOError:
            return count
    raise AssertionError


def small(number: int) -> Frame:
    return frame(number, frame(0).pixels[:4, :4].copy())


@pytest.mark.parametrize("watermark", [END, ABSENT, MAX_WATERMARK + 1, -MAX_WATERMARK - 1])
def test_a_watermark_that_no_message_brings_is_refused_and_the_message_passes(
    ring: Hostile, watermark: int
) -> None:
    ring.writer.send(frame(0), watermark)
    (message,) = messages(polled(ring.reader))
    assert identical(message, frame(0))
    assert ring.reader.rejected == 1
    assert not ring.reader.lost
