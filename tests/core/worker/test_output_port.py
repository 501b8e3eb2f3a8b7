"""The sending end: what cannot be sent is counted, and goes nowhere."""

from __future__ import annotations

import copy
import socket
from collections.abc import Iterator

import numpy as np
import pytest

from followspot.graph.depths import MAX_IN_TRANSIT
from followspot.messages import Array, Header, Message, column
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import Ledger
from followspot.worker.output_port import OutputPort


class Note(Message):
    text: str


class Places(Message):
    xyz: Array = column("N", 3, unit="m")


def output_with_ring(ledger: Ledger) -> tuple[OutputPort, InputQueue, InputQueue, list[str]]:
    """An output port with a reader in the same worker (edge 0) and one across a ring (edge 1)."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    output = OutputPort(Note, ledger.words, lateness=0)
    near = InputQueue("near", ledger.words, ledger.row(0), depth=8, lateness=0)
    far = InputQueue("far", ledger.words, ledger.row(1), depth=8, lateness=0)
    far.reader = RingReader(theirs, Note)
    output.connect([near])
    output.attach(RingWriter([ours], 8), ["a.out -> b.in"], [ledger.row(1)])
    complaints: list[str] = []
    output.refused = complaints.append
    return output, near, far, complaints


def test_a_message_with_texts_too_long_to_travel_is_invalid_on_the_ring_and_nearby() -> None:
    ledger = Ledger(2)
    output, near, far, complaints = output_with_ring(ledger)
    output.send(Note("x" * 100_000), Header("a", 0, 0))
    output.send(Note("short"), Header("a", 1, 10))
    far.poll()
    assert [m.text for m in far.messages] == ["short"]  # type: ignore[attr-defined]
    assert [m.text for m in near.messages] == ["short"]  # type: ignore[attr-defined]
    for edge in (0, 1):
        assert (ledger.count(edge).produced, ledger.count(edge).invalid) == (2, 1)
    assert len(complaints) == 1


class Rings:
    """An output port with two readers over one ring (edges 0, 1) and one on an edge that drops (edge 2)."""

    def __init__(self) -> None:
        self.ledger = Ledger(3)
        self.output = OutputPort(Note, self.ledger.words, lateness=0)
        pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(3)]
        self.ends = [theirs for _, theirs in pairs]
        self.ring = RingWriter([ours for ours, _ in pairs[:2]], 8)
        self.dropping = DroppingWriter(RingWriter([pairs[2][0]], MAX_IN_TRANSIT), 2)
        self.output.attach(self.ring, ["a -> b", "a -> c"], [self.ledger.row(0), self.ledger.row(1)])
        self.output.attach(self.dropping, ["a -> d"], [self.ledger.row(2)])

    def close(self) -> None:
        for writer in self.output.writers:
            writer.close()
        for end in self.ends:
            end.close()

    def kill(self, edge: int) -> None:
        """As the worker finds a reader dead."""
        self.ends[edge].close()
        for writer in self.output.writers:
            writer.drain()
        self.output.update_readers()

    def revive(self, edge: int) -> None:
        """As the worker takes up a reader that was started again."""
        self.ends[edge].close()
        ours, self.ends[edge] = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        if edge == 2:
            self.dropping.replace(0, ours)
        else:
            self.ring.replace(edge, ours)
        self.output.update_readers()

    def send(self, count: int, message: Message = Note("short")) -> None:
        for _ in range(count):
            time = max(0, self.output.watermark)
            self.output.send(type(message)(message.text), Header("a", time, time))  # type: ignore[attr-defined,call-arg]

    def told(self, edge: int) -> tuple[int, int, int]:
        count = self.ledger.count(edge)
        return count.produced, count.away, count.sent


@pytest.fixture
def rings() -> Iterator[Rings]:
    made = Rings()
    yield made
    made.close()


def test_what_is_produced_while_a_reader_is_away_is_counted_on_its_edge_alone(rings: Rings) -> None:
    rings.send(2)
    rings.kill(1)
    rings.send(3)
    assert [rings.told(edge) for edge in range(3)] == [(5, 0, 5), (5, 3, 2), (5, 0, 5)]
    rings.kill(2)
    rings.revive(1)
    rings.send(1)
    assert [rings.told(edge) for edge in range(3)] == [(6, 0, 6), (6, 3, 3), (6, 1, 5)]
    assert rings.ledger.count(2).dropped == 3, "one found no room, two waited for the reader that died"


def test_what_is_refused_while_a_reader_is_away_is_away_there_and_invalid_elsewhere(rings: Rings) -> None:
    rings.kill(0)
    rings.send(1, Note(3))  # type: ignore[arg-type]  # no text
    rings.send(1, Note("x" * 100_000))  # too large to travel
    assert [rings.told(edge) for edge in range(3)] == [(2, 2, 0), (2, 0, 2), (2, 0, 2)]
    assert [rings.ledger.count(edge).invalid for edge in range(3)] == [0, 2, 2]


@pytest.mark.parametrize("noticed", [True, False], ids=["found dead", "replaced at once"])
def test_what_was_on_its_way_to_a_reader_that_died_is_lost_as_soon_as_that_is_known(
    rings: Rings, noticed: bool
) -> None:
    reader = RingReader(rings.ends[1], Note)
    queue = InputQueue("a -> c", rings.ledger.words, rings.ledger.row(1), depth=8, lateness=0)
    queue.reader = reader
    rings.send(5)
    queue.poll()
    queue.take()
    queue.take()
    assert (rings.ledger.count(1).in_flight, rings.ledger.count(1).lost) == (3, 0)
    if noticed:
        rings.kill(1)
        rings.send(1)
    rings.revive(1)
    assert (rings.ledger.count(1).in_flight, rings.ledger.count(1).lost) == (0, 3)
    assert (rings.ledger.count(0).in_flight, rings.ledger.count(0).lost) == (6 if noticed else 5, 0)
    rings.send(2)
    assert (rings.ledger.count(1).in_flight, rings.ledger.count(1).lost) == (2, 3)


def test_edges_that_are_added_later_know_that_a_message_had_rows() -> None:
    ledger = Ledger(3)
    output, *_ = output_with_ring(ledger)
    assert not ledger.count(0).filled
    output.send(Note("short"), Header("a", 0, 1))
    ours, _theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    output.attach(RingWriter([ours], 8), ["a.out -> c.in"], [ledger.row(2)])
    assert [ledger.count(edge).filled for edge in range(3)] == [True] * 3


def test_an_edge_that_leaves_counts_no_more_and_the_others_of_its_ring_go_on() -> None:
    rings = Rings()
    output, ledger = rings.output, rings.ledger
    output.send(Note("both"), Header("a", 0, 0))
    assert output.detach({ledger.row(0)}) == [(rings.ring, [0])]
    rings.ring.dismiss(0)
    output.update_readers()
    output.send(Note("one"), Header("a", 1, 10))
    assert [ledger.count(edge).sent for edge in range(3)] == [1, 2, 2]
    assert output.has_room()
    assert output.detach({ledger.row(1)}) == [(rings.ring, [1])]
    assert output.writers == [rings.dropping]
    output.send(Note("none"), Header("a", 2, 20))
    assert [ledger.count(edge).sent for edge in range(3)] == [1, 2, 3]


def test_messages_that_are_yet_to_be_sent_count_where_they_will_go() -> None:
    ledger = Ledger(2)
    output, _, _, _ = output_with_ring(ledger)
    for _ in range(3):
        output.produced()
    before = output.all_rows
    output.detach({ledger.row(1)})
    output.recount(before, 3)
    assert (ledger.count(0).produced, ledger.count(1).produced) == (3, 0)


@pytest.mark.parametrize("text", ["short", "x" * 100_000, 3])
def test_what_follows_a_message_reaches_all_readers_even_if_the_message_does_not(text: str) -> None:
    """Short, too large to travel, and not of its type."""
    output, near, far, _ = output_with_ring(Ledger(2))
    output.send(Note(text), Header("a", 0, 0), 50)
    far.poll()
    assert (near.watermark, far.watermark, output.announced) == (50, 50, 50)
    assert isinstance(far.reader, RingReader)
    assert far.reader._received == 2, "the greeting and one more datagram"


def test_what_a_message_announces_by_itself_is_not_sent_again() -> None:
    output, near, far, _ = output_with_ring(Ledger(2))
    output.send(Note("a"), Header("a", 0, 10), 11)
    far.poll()
    assert (near.watermark, far.watermark, far.received) == (11, 11, 1)


def test_a_deep_copy_of_a_message_that_was_sent_cannot_change_once_it_is_sent() -> None:
    ledger = Ledger(1)
    output = OutputPort(Places, ledger.words, lateness=0)
    near = InputQueue("near", ledger.words, ledger.row(0), depth=8, lateness=0)
    output.connect([near])
    output.send(Places(np.zeros((2, 3))), Header("a", 0, 0))
    copied = copy.deepcopy(near.messages[0])
    assert isinstance(copied, Places)
    copied.xyz[:] = 1.0
    output.send(copied, Header("a", 1, 10))
    with pytest.raises(ValueError, match="read-only"):
        copied.xyz[:] = 2.0
