"""A ring whose other end dies, is replaced, or sends what it must not."""

from __future__ import annotations

import socket

from tests.core.transport.rings import DEPTH, Ring, frame, messages

from followspot.messages import identical
from followspot.tracking import Blobs, Frame
from followspot.transport.ring.notification import INLINE, NOTIFICATION, SLOT
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Invalid, Watermark


def test_what_was_sent_before_the_writer_died_arrives_and_then_it_is_lost(ring: Ring) -> None:
    ring.writer.send(frame(0))
    ring.writer.want_credit()
    ring.readers[0].poll()
    ring.readers[0].consumed()  # a wake-up that nobody reads: the socket reports a reset at first
    ring.writer.send(frame(1))
    ring.writer.close()
    message = messages(ring.readers[0].poll())[0]
    assert identical(message, frame(1))
    lost_before_the_end_of_file = ring.readers[0].lost
    assert ring.readers[0].poll() == []
    assert (lost_before_the_end_of_file, ring.readers[0].lost) == (False, True)


def test_an_ended_stream_is_not_lost(ring: Ring) -> None:
    ring.writer.send(Watermark(END))
    assert ring.writer.flush()
    ring.writer.close()
    assert ring.readers[0].poll() == [Watermark(END)]
    assert ring.readers[0].poll() == []
    assert not ring.readers[0].lost


def test_a_reader_that_leaves_after_the_end_is_not_lost(ring: Ring) -> None:
    ring.writer.send(Watermark(END))
    ring.readers[0].poll()
    ring.readers[0].close()
    ring.writer.drain()
    assert not ring.writer.filenos()
    assert not ring.writer.lost


def test_a_dead_reader_holds_neither_credit_nor_slots(shared: Ring) -> None:
    kept = []
    for number in range(DEPTH):
        shared.writer.send(frame(number))
    for reader in shared.readers:
        kept += reader.poll()
    for reader in shared.readers[1:]:
        reader.consumed(DEPTH)
    assert shared.writer.credit() == 0
    shared.readers[0].close()
    shared.writer.drain()
    assert shared.writer.lost == {0}
    assert len(shared.writer.filenos()) == 2
    assert shared.writer.credit() == DEPTH
    shared.readers[1].close()
    shared.readers[2].close()
    for number in range(DEPTH):
        shared.writer.send(frame(number))
    assert (set(shared.writer.lost), shared.writer.credit()) == ({0}, 0)  # nobody has noticed yet
    shared.writer.drain()
    assert shared.writer.lost == {0, 1, 2}
    assert shared.writer.credit() == DEPTH
    shared.writer.send(frame(10))
    assert shared.writer.flush()


def test_a_replaced_reader_begins_with_the_next_message(shared: Ring) -> None:
    kept = []
    for number in range(20):
        if number == 10:
            shared.readers[1].close()
            shared.writer.drain()
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            shared.writer.replace(1, ours)
            shared.readers[1] = RingReader(theirs, Frame)
            assert not shared.writer.lost
        shared.writer.send(frame(number))
        for reader in shared.readers:
            kept += messages(reader.poll())
            reader.consumed()
    assert [message.header.seq for message in kept] == [n for n in range(20) for _ in range(3)]
    assert all(identical(message, frame(message.header.seq)) for message in kept)


def test_a_replaced_reader_starts_with_nothing_to_release(ring: Ring) -> None:
    loans, kept = ring.use_all_slots()
    assert ring.writer.credit() == 0
    ring.readers[0].close()
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ring.writer.replace(0, ours)
    assert ring.writer.credit() == DEPTH
    theirs.close()
    assert len(loans) == len(kept)


def test_a_message_of_another_type_is_invalid_and_takes_its_place() -> None:
    ring = Ring()
    reader = RingReader(ring.readers[0]._socket, Blobs)
    for number in range(3 * DEPTH):
        ring.writer.send(frame(number))
        (token,) = reader.poll()
        assert isinstance(token, Invalid)
        assert "Blobs" in token.reason
        reader.consumed()
    assert ring.writer.credit() == DEPTH
    ring.close()


def test_broken_datagrams_are_invalid_with_a_reason() -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    writer, reader = RingWriter([ours], DEPTH), RingReader(theirs, Frame)
    writer.send(frame(0))
    assert len(messages(reader.poll())) == 1
    for datagram in (
        NOTIFICATION.pack(INLINE, 0, 0, 10**6, 1),
        NOTIFICATION.pack(SLOT, 0, 999, 10, 2),
        NOTIFICATION.pack(SLOT, 7, 0, 10, 3),
        NOTIFICATION.pack(SLOT, 0, 0, 2**31, 4),
        NOTIFICATION.pack(SLOT, 0, 0, 10, 5) + b"odd",
    ):
        ours.send(datagram)
        (token,) = reader.poll()
        assert isinstance(token, Invalid)
        assert token.reason
    for datagram in (b"x", bytes(64)):
        ours.send(datagram)
        assert reader.poll() == []
    writer.close()
    reader.close()


def test_each_message_that_never_came_is_invalid_in_its_place() -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    writer, reader = RingWriter([ours], DEPTH), RingReader(theirs, Frame)
    writer._sequence = 2
    writer.send(frame(2))
    *missing, message = reader.poll()
    assert [str(token) for token in missing] == [
        str(Invalid(f"gap: message {number} of the port never came", missing=True)) for number in range(2)
    ]
    assert isinstance(message, Frame)
    writer.close()
    reader.close()


def test_a_dismissed_reader_holds_no_credit_and_keeps_the_slots_of_what_it_has(shared: Ring) -> None:
    first, *others = shared.readers
    for number in range(DEPTH):
        shared.writer.send(frame(number))
    kept = first.poll()
    for reader in others:
        reader.poll()
        reader.consumed(DEPTH)
    assert shared.writer.credit() == 0
    shared.writer.dismiss(0)
    assert not shared.writer.lost
    assert len(shared.writer.filenos()) == 2
    for number in range(DEPTH, 10 * DEPTH):
        assert shared.writer.credit() > 0
        shared.writer.send(frame(number))
        for reader in others:
            (message,) = messages(reader.poll())
            assert identical(message, frame(number))
            reader.consumed()
    assert first.poll() == [], "it gets nothing more"
    assert all(identical(message, frame(n)) for n, message in enumerate(messages(kept)))
    first.close()
    shared.writer.drain()
    assert not shared.writer.lost
    assert not shared.writer.newly_dead()


def test_a_reader_has_caught_up_once_it_has_taken_all_that_was_sent(ring: Ring) -> None:
    (reader,) = ring.readers
    assert not reader.caught_up, "the writer has introduced itself"
    reader.poll()
    assert reader.caught_up
    ring.writer.send(Watermark(5))
    assert not reader.caught_up
    reader.poll()
    assert reader.caught_up
    ring.writer.close()
    reader.poll()
    assert reader.caught_up, "nothing more comes"
