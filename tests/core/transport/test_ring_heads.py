"""Heads of messages on a ring: packed and read once while they repeat, and never believed unseen."""

from __future__ import annotations

import math
import socket
from collections.abc import Callable, Iterator
from struct import pack
from typing import Any

import numpy as np
import pytest
from tests.core.transport.rings import DEPTH, Ring, frame, messages

from followspot.message_checks.sealing import seal
from followspot.messages import MAX_TIME, Array, Header, Message, column, identical, stamped
from followspot.transport.codec import codec_of
from followspot.transport.ring import heads
from followspot.transport.ring.heads import HeadPacker, HeadReader
from followspot.transport.ring.notification import INLINE, MESSAGE, SLOT
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import UNKNOWN, Invalid
from followspot.transport.wire import pack_head


class Reading(Message):
    """Two arrays and a number whose bits matter."""

    scale: float
    label: str
    values: Array = column("N", unit="m")
    truth: Array = column("N", dtype="?")


def reading(number: int, rows: int = 3, scale: float = 1.0, source: str = "imu/a") -> Reading:
    values = np.arange(rows, dtype=float) + number
    message = seal(Reading(scale, "left", values, values % 2 == 0))
    return stamped(message, Header(source, number, number))


class Wire:
    """A ring of readings, and the writer's socket, on which anything may be sent."""

    def __init__(self) -> None:
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.writer = RingWriter([self.socket], DEPTH)
        self.reader = RingReader(theirs, Reading)

    def passed(self, message: Reading) -> Reading:
        assert self.writer.credit()
        self.writer.send(message)
        (arrived,) = messages(self.reader.poll())
        self.reader.consumed()
        assert isinstance(arrived, Reading)
        return arrived

    def refused(self, datagram: bytes) -> str:
        """The reason for which a datagram in place of the next message is invalid."""
        self.writer._sequence += 1
        self.socket.send(datagram)
        (token,) = [token for _ in range(2) for token in self.reader.poll()]
        self.reader.consumed()
        assert isinstance(token, Invalid)
        return token.reason

    def close(self) -> None:
        self.writer.close()
        self.reader.close()


@pytest.fixture
def wire() -> Iterator[Wire]:
    made = Wire()
    yield made
    made.close()


def test_messages_that_differ_in_any_part_of_their_head_arrive_bit_for_bit(wire: Wire) -> None:
    sent = [
        *(reading(0), reading(1), reading(2, rows=0), reading(3, rows=5000), reading(4, rows=5000)),
        *(
            reading(5, scale=0.0),
            reading(6, scale=-0.0),
            reading(7, scale=math.nan),
            reading(8, scale=math.nan),
        ),
        *(reading(9, source="imu/b"), reading(10, source="imu/b")),
    ]
    arrived = [wire.passed(message) for message in sent]
    assert [identical(a, b) for a, b in zip(arrived, sent, strict=True)] == [True] * len(sent)
    assert math.copysign(1, arrived[6].scale) == -1


def test_a_head_that_repeats_is_packed_and_read_once() -> None:
    packer, reader = HeadPacker(type(frame(0))), HeadReader(type(frame(0)))
    heads = []
    for number in range(2):
        head, size = packer.pack(frame(number), [frame(number).pixels])
        data = bytearray(MESSAGE.size) + head
        read, end = reader.read(data, MESSAGE.size, len(data))
        assert (size, end) == (60 * 80 * 3, len(data))
        heads.append((head, read))
    assert heads[0][0] is heads[1][0]
    assert heads[0][1] is heads[1][1]


def test_heads_that_alternate_are_packed_and_read_once_each(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.0 and -0.0 are equal and have heads of their own."""
    done: list[str] = []

    def noted(name: str) -> Callable[[Any], Any]:
        by = getattr(heads, name)

        def call(data: Any) -> Any:
            done.append(name)
            return by(data)

        return call

    for name in ("pack_head", "unpack_head"):
        monkeypatch.setattr(heads, name, noted(name))
    kinds = [(3, 0.0), (2, 0.0), (3, -0.0), (3, 1.0)]
    for number in range(5 * len(kinds)):
        rows, scale = kinds[number % len(kinds)]
        message = reading(number, rows, scale)
        assert identical(wire.passed(message), message)
    assert sorted(done) == ["pack_head"] * len(kinds) + ["unpack_head"] * len(kinds)


def test_a_port_with_ever_new_heads_is_not_remembered_for_ever(wire: Wire) -> None:
    for number in range(150):
        message = reading(number, scale=float(number))
        assert identical(wire.passed(message), message)
    assert wire.writer._heads is not None
    assert len(wire.writer._heads._known) <= 64
    assert len(wire.reader._decoder._heads._known) <= 64


def test_a_datagram_that_ends_within_its_head_is_invalid_though_the_rest_lies_in_the_buffer(
    wire: Wire,
) -> None:
    wire.passed(reading(0))
    head, size = HeadPacker(Reading).pack(reading(1), [reading(1).values, reading(1).truth])
    told = MESSAGE.pack(INLINE, 0, 0, size, 1, 1, 1, 0, UNKNOWN)
    assert "does not fit" in wire.refused((told + head)[:-1])
    assert identical(wire.passed(reading(2)), reading(2))


@pytest.mark.parametrize("places", [(0, 40064), (0, -64), (0, 1), (1 << 62, 0)])
def test_arrays_that_lie_outside_what_was_sent_are_invalid_and_keep_no_slot(
    wire: Wire, places: tuple[int, int]
) -> None:
    kept = wire.passed(reading(0, rows=5000))
    head, _ = HeadPacker(Reading).pack(kept, [kept.values, kept.truth])
    told = MESSAGE.pack(SLOT, 0, 1, 45_056, 1, 1, 1, 0, UNKNOWN) + head
    assert "outside" in wire.refused(told + pack("<2q", *places))
    assert identical(wire.passed(reading(2, rows=5000)), reading(2, rows=5000))
    assert identical(kept, reading(0, rows=5000))


def test_places_of_more_or_fewer_arrays_are_invalid(wire: Wire) -> None:
    message = reading(0, rows=5000)
    wire.passed(message)
    head, _ = HeadPacker(Reading).pack(message, [message.values, message.truth])
    for number, size in enumerate((0, 8, 24, 17), 1):
        assert "places" in wire.refused(
            MESSAGE.pack(SLOT, 0, 1, 45_056, number, 1, 1, 0, UNKNOWN) + head + bytes(size)
        )


@pytest.mark.parametrize("source", ["x" * 1001, 7, None])
def test_a_source_that_has_no_name_is_invalid(wire: Wire, source: object) -> None:
    message = reading(0)
    arrays = [message.values, message.truth]
    head = pack_head(("Reading", source, *codec_of(Reading).contract(message, arrays)))
    assert "source" in wire.refused(MESSAGE.pack(INLINE, 0, 0, 128, 0, 0, 0, 0, UNKNOWN) + head + bytes(128))


@pytest.mark.parametrize("numbers", [(-2, 0, 0), (0, MAX_TIME + 1, 0), (0, 0, -MAX_TIME - 1)])
def test_a_header_out_of_range_is_invalid(wire: Wire, numbers: tuple[int, int, int]) -> None:
    message = reading(0)
    head, size = HeadPacker(Reading).pack(message, [message.values, message.truth])
    assert "out of range" in wire.refused(
        MESSAGE.pack(INLINE, 0, 0, size, 0, *numbers, UNKNOWN) + head + bytes(size)
    )


def test_truth_values_other_than_0_and_1_are_invalid(wire: Wire) -> None:
    message = reading(0)
    head, size = HeadPacker(Reading).pack(message, [message.values, message.truth])
    assert "truth" in wire.refused(
        MESSAGE.pack(INLINE, 0, 0, size, 0, 0, 0, 0, UNKNOWN) + head + b"\2" * size
    )


def test_an_invalid_message_gives_its_slot_back() -> None:
    """The truth values of a message in a slot are overwritten on their way."""
    ring = Ring(kind=Reading)
    ring.writer.send(reading(0, rows=20_000))  # slots with room for a loan and what lies behind it
    ring.readers[0].consumed(len(ring.readers[0].poll()))
    for number in range(1, 3 * DEPTH):
        loan = ring.loan((5000,), "?")
        loan[:] = True
        behind = loan.view(np.uint8)
        message = seal(Reading(1.0, "left", np.zeros(5000), loan))
        ring.writer.send(stamped(message, Header("imu/a", number, number)))
        behind[7] = 9
        (token,) = ring.readers[0].poll()
        assert isinstance(token, Invalid)
        ring.readers[0].consumed()
        del loan, behind, message
    assert ring.writer.credit() == DEPTH
    ring.close()
