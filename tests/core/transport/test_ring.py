"""The ring between a writer and readers of one process; other processes are in test_edges.py."""

from __future__ import annotations

import select

import numpy as np
import pytest
from tests.core.transport.rings import DEPTH, Ring, frame, messages

from followspot.messages import Message, identical
from followspot.transport.token import END, Token, Watermark


def test_messages_and_watermarks_arrive_in_order_bit_for_bit(ring: Ring) -> None:
    sent: list[Message | Watermark] = [
        frame(0),
        Watermark(1),
        frame(2),
        frame(3, np.zeros((0, 0, 1), np.uint8)),
        Watermark(END),
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
    reader.consumed(0)
    assert not ready.poll(0), "it asked once"
    assert not writer.lost


def test_watermarks_are_merged_while_the_socket_is_full_and_the_end_arrives(ring: Ring) -> None:
    writer, reader = ring.writer, ring.readers[0]
    for time in range(5000):
        writer.send(Watermark(time))
    writer.send(Watermark(END))
    assert not writer.flush()
    tokens: list[Token] = []
    for _ in range(50):
        tokens += reader.poll()
        writer.drain()
    assert writer.flush()
    bounds = [token.time for token in tokens if isinstance(token, Watermark)]
    assert bounds == sorted(bounds)
    assert bounds[-1] == END
    assert len(bounds) < 5000


def test_a_full_socket_wakes_the_writer_when_the_reader_made_room(ring: Ring) -> None:
    for time in range(5000):
        ring.writer.send(Watermark(time))
    ready = select.poll()
    ready.register(ring.writer.filenos()[0], select.POLLIN)
    assert not ready.poll(0)
    ring.readers[0].poll()
    assert ready.poll(0)


def test_slots_in_flight_hold_the_credit_and_reading_wakes_the_writer(ring: Ring) -> None:
    loans, kept = ring.use_all_slots()
    ring.writer.want_credit()
    assert ring.writer.credit() == 0
    kept += ring.readers[0].poll()
    ready = select.poll()
    ready.register(ring.writer.filenos()[0], select.POLLIN)
    assert ready.poll(0)
    assert ring.writer.credit() == 2
    assert all(identical(message, frame(n)) for n, message in enumerate(messages(kept)))
    assert len(loans) == DEPTH + 1


def test_the_watermark_after_a_message_comes_in_the_same_datagram(ring: Ring) -> None:
    ring.writer.send(frame(0), 7)
    ring.writer.send(frame(8, np.zeros((2, 2, 1), np.uint8)), 9)
    first, then, second, last = ring.readers[0].poll()
    assert ring.readers[0]._received == 4, "the greeting, the memory of the slots, and a datagram each"
    assert (then, last) == (Watermark(7), Watermark(9))
    for message, number in ((first, 0), (second, 8)):
        assert isinstance(message, Message)
        assert message.header.seq == number
