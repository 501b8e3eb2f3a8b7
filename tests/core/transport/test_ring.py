"""The ring between a writer and readers of one process; other processes are in test_edges.py."""

from __future__ import annotations

import gc
import select
import socket
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from followspot.messages import Array, Header, Message, column, identical, seal, stamped
from followspot.tracking import Blobs, Frame
from followspot.transport.doorbell import DOORBELL, INLINE, SLOT
from followspot.transport.ring_reader import RingReader
from followspot.transport.ring_writer import RingWriter
from followspot.transport.token import END, Invalid, Settled, Token

DEPTH = 4
SHAPE = (60, 80, 3)


class Stereo(Message):
    """Two arrays, the second of which may lie in a loaned slot as well."""

    left: Array = column("H", "W", dtype="u1")
    right: Array = column("H", "W", dtype="u1")


class Ring:
    """A writer and its readers."""

    def __init__(self, readers: int = 1, kind: type[Message] = Frame, depth: int = DEPTH) -> None:
        pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(readers)]
        self.writer = RingWriter([ours for ours, _ in pairs], depth)
        self.readers = [RingReader(theirs, kind) for _, theirs in pairs]

    def loan(self, shape: tuple[int, ...], dtype: str) -> Array:
        """A loan that must not fail."""
        array = self.writer.loan(shape, dtype)
        assert array is not None
        return array

    def close(self) -> None:
        self.writer.close()
        for reader in self.readers:
            reader.close()


@pytest.fixture
def ring() -> Iterator[Ring]:
    made = Ring()
    yield made
    made.close()


@pytest.fixture
def shared() -> Iterator[Ring]:
    """One writer, three readers."""
    made = Ring(3)
    yield made
    made.close()


def frame(number: int, pixels: Array | None = None) -> Frame:
    if pixels is None:
        pixels = np.full(SHAPE, number % 251, np.uint8)
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number))


def messages(tokens: list[Token]) -> list[Message]:
    assert all(isinstance(token, Message) for token in tokens), tokens
    return [token for token in tokens if isinstance(token, Message)]


def address(array: Array) -> int:
    return int(array.ctypes.data)


def test_messages_and_settled_times_arrive_in_order_bit_for_bit(ring: Ring) -> None:
    sent: list[Message | Settled] = [
        frame(0),
        Settled(1),
        frame(2),
        frame(3, np.zeros((0, 0, 1), np.uint8)),
        Settled(END),
    ]
    for original in sent:
        ring.writer.send(original)
    arrived = ring.readers[0].poll()
    assert len(arrived) == len(sent)
    for token, original in zip(arrived, sent, strict=True):
        if isinstance(original, Message):
            assert isinstance(token, Message)
            assert identical(token, original)
        else:
            assert token == original


def test_every_reader_gets_every_message_from_the_same_memory(shared: Ring) -> None:
    shared.writer.send(frame(0))
    views = [messages(reader.poll())[0] for reader in shared.readers]
    assert all(identical(view, frame(0)) for view in views)


def test_credit_is_that_of_the_slowest_reader(shared: Ring) -> None:
    for number in range(DEPTH):
        shared.writer.send(frame(number))
    assert shared.writer.credit() == 0
    for reader in shared.readers:
        reader.poll()
    shared.readers[0].consumed(DEPTH)
    shared.readers[1].consumed(DEPTH)
    assert shared.writer.credit() == 0
    shared.readers[2].consumed(3)
    assert shared.writer.credit() == 3


def test_a_message_without_credit_is_a_mistake_of_the_caller(ring: Ring) -> None:
    for number in range(DEPTH):
        ring.writer.send(frame(number))
    with pytest.raises(RuntimeError, match="credit"):
        ring.writer.send(frame(DEPTH))


def test_the_writer_is_woken_by_credit_only_if_it_asked(ring: Ring) -> None:
    writer, reader = ring.writer, ring.readers[0]
    ready = select.poll()
    ready.register(writer.filenos()[0], select.POLLIN)
    writer.send(frame(0))
    reader.poll()
    assert not ready.poll(0)
    writer.want_credit()
    assert not ready.poll(0)
    reader.consumed()
    assert ready.poll(0)
    writer.drain()
    assert not ready.poll(0)
    assert not writer.lost


def test_arrays_are_read_only_views_in_shared_memory(ring: Ring) -> None:
    loan = ring.loan(SHAPE, "u1")
    loan[:] = 9
    ring.writer.send(frame(0, loan))
    message = messages(ring.readers[0].poll())[0]
    assert isinstance(message, Frame)
    with pytest.raises(ValueError, match="read-only"):
        message.pixels[0, 0, 0] = 1
    with pytest.raises(ValueError, match="cannot set WRITEABLE"):
        message.pixels.flags.writeable = True


def test_a_loan_is_sent_in_place(ring: Ring) -> None:
    """A change behind the seal, which nobody may make, shows at the reader: it is the same memory."""
    loan = ring.loan(SHAPE, "u1")
    behind = loan.view()
    loan[:] = 1
    ring.writer.send(frame(0, loan))
    message = messages(ring.readers[0].poll())[0]
    behind[:] = 2
    assert isinstance(message, Frame)
    assert (message.pixels == 2).all()


def test_a_loan_can_be_sent_in_place_once_and_by_copy_again(ring: Ring) -> None:
    loan = ring.loan(SHAPE, "u1")
    behind = loan.view()
    behind[:] = 1
    ring.writer.send(frame(0, loan))
    ring.writer.send(frame(1, loan))
    behind[:] = 2
    first, second = messages(ring.readers[0].poll())
    assert isinstance(first, Frame)
    assert isinstance(second, Frame)
    assert (first.pixels == 2).all()
    assert (second.pixels == 1).all()


def test_an_unsent_loan_returns_when_it_dies(ring: Ring) -> None:
    places = set()
    for _ in range(20):
        loan = ring.loan(SHAPE, "u1")
        places.add(address(loan))
        del loan
    assert len(places) == 1


def test_hoarded_loans_come_to_an_end_and_never_take_the_credit(ring: Ring) -> None:
    found = [ring.writer.loan(SHAPE, "u1") for _ in range(3 * DEPTH)]
    loans = [loan for loan in found if loan is not None]
    assert 0 < len(loans) < len(found)
    assert len({address(loan) for loan in loans}) == len(loans)
    for number, loan in enumerate(loans):
        loan[:] = number
    for number in range(5 * DEPTH):
        assert ring.writer.credit() > 0
        ring.writer.send(frame(number))
        message = messages(ring.readers[0].poll())[0]
        assert identical(message, frame(number))
        ring.readers[0].consumed()
    assert all((loan == number).all() for number, loan in enumerate(loans))


def test_small_arrays_are_not_lent_for_they_travel_in_the_datagram(ring: Ring) -> None:
    assert ring.writer.loan((10, 10), "f8") is None


def test_a_loan_is_not_reused_while_this_process_keeps_the_message(ring: Ring) -> None:
    loan = ring.loan(SHAPE, "u1")
    loan[:] = 7
    kept = frame(0, loan)
    ring.writer.send(kept)
    del loan
    for number in range(1, 50):
        ring.readers[0].poll()
        ring.readers[0].consumed()
        again = ring.loan(SHAPE, "u1")
        again[:] = number
        ring.writer.send(frame(number, again))
    assert (kept.pixels == 7).all()


def test_other_arrays_of_a_message_do_not_overwrite_its_loan() -> None:
    """Both arrays are views of one loan; the second is not where it would be put behind the first."""
    ring = Ring(kind=Stereo)
    for side in (40, 64):  # with room behind the loan, and without
        loan = ring.loan((4, side, 64), "u1")
        loan[:] = np.arange(4)[:, None, None]
        ring.writer.send(stamped(seal(Stereo(loan[3], loan[0])), Header("", 0, 0)))
        message = messages(ring.readers[0].poll())[0]
        ring.readers[0].consumed()
        assert isinstance(message, Stereo)
        assert (message.left == 3).all()
        assert (message.right == 0).all()
        assert (loan == np.arange(4)[:, None, None]).all()
    ring.close()


def test_a_reader_that_keeps_every_message_never_stalls_or_changes_them(shared: Ring) -> None:
    """Over its share of slots it gets copies; the other readers do not notice."""
    kept: list[Message] = []
    for number in range(100):
        assert shared.writer.credit() > 0
        shared.writer.send(frame(number))
        for reader in shared.readers:
            arrived = messages(reader.poll())
            if reader is not shared.readers[1] or number % 3:
                kept += arrived
            reader.consumed()
    del arrived
    assert all(identical(message, frame(message.header.seq)) for message in kept)


def test_slots_come_back_when_the_last_view_dies(ring: Ring) -> None:
    for number in range(DEPTH):
        ring.writer.send(frame(number))
    arrived = messages(ring.readers[0].poll())
    rows = [message.pixels[3] for message in arrived if isinstance(message, Frame)]
    ring.readers[0].consumed(DEPTH)
    arrived.clear()
    for number in range(100, 150):
        ring.writer.send(frame(number))
        ring.readers[0].poll()
        ring.readers[0].consumed()
    assert [int(row[0, 0]) for row in rows] == list(range(DEPTH))


def test_a_larger_message_brings_larger_slots_and_leaves_the_old_ones_to_their_holders(ring: Ring) -> None:
    kept = []
    for number, side in enumerate((40, 100, 30, 400, 1000, 20)):
        ring.writer.send(frame(number, np.full((side, side, 3), number, np.uint8)))
        kept += messages(ring.readers[0].poll())
        ring.readers[0].consumed()
    for number, message in enumerate(kept):
        assert isinstance(message, Frame)
        assert (message.pixels == number).all()


def test_settled_times_are_merged_while_the_socket_is_full_and_the_end_arrives(ring: Ring) -> None:
    writer, reader = ring.writer, ring.readers[0]
    for bound in range(5000):
        writer.send(Settled(bound))
    writer.send(Settled(END))
    assert not writer.flush()
    tokens: list[Token] = []
    for _ in range(50):
        tokens += reader.poll()
        writer.drain()
    assert writer.flush()
    bounds = [token.bound for token in tokens if isinstance(token, Settled)]
    assert bounds == sorted(bounds)
    assert bounds[-1] == END
    assert len(bounds) < 5000


def test_a_full_socket_wakes_the_writer_when_the_reader_made_room(ring: Ring) -> None:
    for bound in range(5000):
        ring.writer.send(Settled(bound))
    ready = select.poll()
    ready.register(ring.writer.filenos()[0], select.POLLIN)
    assert not ready.poll(0)
    ring.readers[0].poll()
    assert ready.poll(0)


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
    ring.writer.send(Settled(END))
    assert ring.writer.flush()
    ring.writer.close()
    assert ring.readers[0].poll() == [Settled(END)]
    assert ring.readers[0].poll() == []
    assert not ring.readers[0].lost


def test_a_reader_that_leaves_after_the_end_is_not_lost(ring: Ring) -> None:
    ring.writer.send(Settled(END))
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
    """All slots have been used: by loans, by messages that the first reader kept, and by two in flight."""
    loans = [ring.loan(SHAPE, "u1") for _ in range(DEPTH + 1)]
    kept = []
    for number in range(DEPTH + 1):
        ring.writer.send(frame(number))
        kept += ring.readers[0].poll()
        ring.readers[0].consumed()
    ring.writer.send(frame(5))
    ring.writer.send(frame(6))
    assert ring.writer.credit() == 0
    ring.readers[0].close()
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ring.writer.replace(0, ours)
    assert ring.writer.credit() == DEPTH
    theirs.close()
    assert len(loans) == len(kept)


def test_slots_in_flight_hold_the_credit_and_reading_wakes_the_writer(ring: Ring) -> None:
    loans = [ring.loan(SHAPE, "u1") for _ in range(DEPTH + 1)]
    kept = []
    for number in range(DEPTH + 1):
        ring.writer.send(frame(number))
        kept += ring.readers[0].poll()
        ring.readers[0].consumed()
    ring.writer.send(frame(5))
    ring.writer.send(frame(6))
    ring.writer.want_credit()
    assert ring.writer.credit() == 0
    kept += ring.readers[0].poll()
    ready = select.poll()
    ready.register(ring.writer.filenos()[0], select.POLLIN)
    assert ready.poll(0)
    assert ring.writer.credit() == 2
    assert all(identical(message, frame(n)) for n, message in enumerate(messages(kept)))
    assert len(loans) == DEPTH + 1


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
        DOORBELL.pack(INLINE, 0, 0, 10**6, 1),
        DOORBELL.pack(SLOT, 0, 999, 10, 2),
        DOORBELL.pack(SLOT, 7, 0, 10, 3),
        DOORBELL.pack(SLOT, 0, 0, 2**31, 4),
        DOORBELL.pack(SLOT, 0, 0, 10, 5) + b"odd",
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
        str(Invalid(f"gap: message {number} of the port never came")) for number in range(2)
    ]
    assert isinstance(message, Frame)
    writer.close()
    reader.close()


def test_nothing_is_left_when_both_ends_are_gone(ring: Ring) -> None:
    """The memory is unmapped when the last view dies: no reference cycle keeps it."""
    gc.disable()
    before = mapped_slots()
    try:
        ring.writer.send(frame(0))
        message = messages(ring.readers.pop().poll())[0]
        ring.close()
        ring.writer = RingWriter([], DEPTH)
        assert mapped_slots() == before + 1
        assert identical(message, frame(0))
        del message
        assert mapped_slots() == before
    finally:
        gc.enable()


def mapped_slots() -> int:
    return Path("/proc/self/maps").read_text().count("followspot-slots")
