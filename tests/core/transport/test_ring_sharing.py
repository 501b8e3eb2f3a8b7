"""Edges from one port to one process share datagrams, and each keeps its own credit, death and end."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import numpy as np
import pytest
from tests.core.transport.rings import DEPTH, frame, messages

from followspot.messages import Message, identical
from followspot.tracking import Frame
from followspot.transport.ring.links import ReaderLocation
from followspot.transport.ring.notification import CARRIES, NOTIFICATION
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Token, Watermark

SMALL = np.zeros((2, 2, 1), np.uint8)


class Shared:
    """Edges 0 and 1 to one worker, and edge 2 to another one."""

    def __init__(self) -> None:
        pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(3)]
        self.sockets = [ours for ours, _ in pairs]
        homes = [ReaderLocation("near", 0), ReaderLocation("near", 1), ReaderLocation("far", 2)]
        self.writer = RingWriter(self.sockets, DEPTH, homes)
        self.readers: list[RingReader] = []
        self.readers += [RingReader(theirs, Frame, self.reader_beside) for _, theirs in pairs]
        self.notified = 0
        self.readers[1].notify = self.note

    def reader_beside(self, edge: int) -> RingReader | None:
        return self.readers[edge] if edge in (0, 1) else None

    def note(self) -> None:
        self.notified += 1

    def datagrams(self) -> list[int]:
        """How many have come to each socket."""
        return [reader._received for reader in self.readers]

    def close(self) -> None:
        self.writer.close()
        for reader in self.readers:
            reader.close()


@pytest.fixture
def shared() -> Iterator[Shared]:
    made = Shared()
    yield made
    made.close()


def told(tokens: list[Token]) -> list[int]:
    """Frame numbers and watermarks."""
    return [token.header.seq if isinstance(token, Message) else token.time for token in tokens]  # type: ignore[union-attr]


def test_readers_of_one_process_get_one_datagram_and_the_same_messages(shared: Shared) -> None:
    for reader in shared.readers:
        assert reader.poll() == []
    before = shared.datagrams()
    for number in range(3):
        shared.writer.send(frame(number, SMALL), 100 + number)
    got = [reader.poll() for reader in shared.readers]
    assert [told(tokens) for tokens in got] == [[0, 100, 1, 101, 2, 102]] * 3
    assert all(one is other for one, other in zip(got[0], got[1], strict=True))
    assert [now - then for now, then in zip(shared.datagrams(), before, strict=True)] == [3, 0, 3]
    assert shared.notified == 1


def test_credit_is_that_of_the_slowest_of_them(shared: Shared) -> None:
    for number in range(DEPTH):
        shared.writer.send(frame(number))
    for reader in shared.readers:
        reader.poll()
    for index in (0, 2):
        shared.readers[index].consumed(DEPTH)
    assert shared.writer.credit() == 0
    shared.writer.want_credit()
    shared.readers[1].consumed(1)
    assert shared.sockets[1].recv(1) == b"\1"
    assert shared.writer.credit() == 1


def test_a_slot_is_kept_until_the_last_of_them_lets_go(shared: Shared) -> None:
    kept: list[Message] = []
    for number in range(4 * DEPTH):
        shared.writer.send(frame(number))
        for index, reader in enumerate(shared.readers):
            (message,) = messages(reader.poll())
            kept += [message] if index == 1 and number % 3 == 0 else []
            reader.consumed()
    assert all(identical(message, frame(message.header.seq)) for message in kept)


def test_their_process_dies_as_one(shared: Shared) -> None:
    shared.writer.send(frame(0))
    shared.readers[0].poll()
    shared.readers[0].close()
    shared.readers[1].close()
    shared.writer.drain()
    assert shared.writer.lost == {0, 1}
    assert sorted(shared.writer.newly_dead()) == [(0, 1), (1, 1)]


@pytest.mark.parametrize("waits", [False, True])
def test_their_process_was_sent_the_end_for_both_or_for_neither(shared: Shared, waits: bool) -> None:
    """waits: for room in the socket that they share."""
    sent = 0
    while waits and shared.writer.flush():
        sent += 1
        shared.writer.send(Watermark(sent))
    shared.writer.send(Watermark(END))
    shared.readers[0].close()
    shared.readers[1].close()
    shared.writer.drain()
    assert shared.writer.lost == ({0, 1} if waits else frozenset())


def test_a_reader_that_takes_their_place_has_datagrams_of_its_own(shared: Shared) -> None:
    shared.readers[0].close()
    shared.readers[1].close()
    for index in (1, 0):
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        shared.writer.replace(index, ours)
        shared.readers[index] = RingReader(theirs, Frame, shared.reader_beside)
        shared.writer.send(frame(index, SMALL))
    assert not shared.writer.lost
    assert [told(reader.poll()) for reader in shared.readers] == [[0], [1, 0], [1, 0]]


def test_what_the_writer_sent_before_it_died_comes_before_its_loss(shared: Shared) -> None:
    """Though the second reader finds the death first, by its own socket."""
    shared.readers[1].poll()
    shared.readers[0].poll()
    shared.writer.send(frame(0))
    shared.writer.close()
    tokens: list[Token] = []
    while not shared.readers[1].broken:
        tokens += shared.readers[1].poll()
    assert told(tokens) == [0]
    assert shared.readers[1].lost
    assert told(shared.readers[0].poll()) == [0]
    assert shared.readers[0].lost


def test_the_end_comes_to_both(shared: Shared) -> None:
    shared.writer.send(Watermark(END))
    assert [told(reader.poll()) for reader in shared.readers] == [[END]] * 3
    shared.close()
    assert not shared.writer.lost
    assert not any(reader.lost for reader in shared.readers)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_an_edge_goes_on_when_the_one_that_carried_it_leaves(shared: Shared, order: tuple[int, int]) -> None:
    """What was on its way comes first, whichever socket is looked at first; slots are used on and on."""
    for reader in shared.readers:
        reader.poll()
    shared.writer.send(frame(0), 50)
    shared.writer.dismiss(0)
    shared.writer.send(frame(1))
    got: dict[int, list[Token]] = {}
    for index in order:
        got[index] = shared.readers[index].poll()
    got[1] += shared.readers[1].poll()
    assert told(got[1]) == [0, 50, 1]
    assert told(got[0]) == [0, 50]
    shared.readers[0].close()
    shared.readers[1].consumed(2)
    got.clear()
    shared.readers[2].poll()
    shared.readers[2].consumed(2)
    for number in range(2, 6 * DEPTH):
        shared.writer.send(frame(number))
        for index in (1, 2):
            assert told(shared.readers[index].poll()) == [number]
            shared.readers[index].consumed()
    assert not shared.writer.lost


def test_what_waited_for_the_socket_of_the_one_that_leaves_goes_to_the_other(shared: Shared) -> None:
    sent = 0
    while shared.writer.flush():
        sent += 1
        shared.writer.send(Watermark(sent))
    shared.writer.send(frame(sent, SMALL))
    shared.writer.dismiss(0)
    shared.writer.flush()
    tokens: list[Token] = []
    while not (tokens and isinstance(tokens[-1], Message)):
        tokens += shared.readers[1].poll()
        shared.readers[0].hand_over()
    assert told(tokens) == [*range(1, sent + 1), sent]


def test_an_edge_that_leaves_is_handed_nothing_more(shared: Shared) -> None:
    shared.writer.send(frame(0))
    assert told(shared.readers[0].poll()) == [0]
    shared.writer.dismiss(1)
    shared.readers[1].close()
    for number in range(1, 3 * DEPTH):
        for index in (0, 2):
            shared.readers[index].poll()
            shared.readers[index].consumed()
        shared.writer.send(frame(number))
    assert shared.readers[1]._arrived != [], "what it was handed before is its own"
    assert len(messages(shared.readers[1]._arrived)) == 1


def test_a_reader_that_is_closed_hands_over_what_had_arrived(shared: Shared) -> None:
    shared.readers[1].poll()
    shared.writer.send(frame(0))
    shared.readers[0].hand_over()
    shared.readers[0].close()
    assert told(shared.readers[1].poll()) == [0]


@pytest.mark.parametrize("edge", [0, 2, 7, -1])
def test_a_port_that_is_not_the_writers_is_not_handed_over(shared: Shared, edge: int) -> None:
    """Its own edge, one of another process, and one that nobody knows."""
    shared.readers[0].poll()
    shared.sockets[0].send(NOTIFICATION.pack(CARRIES, 0, 0, 0, edge))
    assert shared.readers[0].poll() == []
    assert shared.readers[0].rejected == 1
