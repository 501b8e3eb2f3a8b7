"""A message survives the wire bit for bit; anything else is an InvalidMessage with a reason."""

from __future__ import annotations

import contextlib
import random
import struct

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from followspot.message_checks.sealing import seal
from followspot.messages import (
    MAX_SEQ,
    MAX_TIME,
    Array,
    Header,
    InvalidMessage,
    Message,
    column,
    identical,
    stamped,
)
from followspot.tracking import Blobs, Forecast, Frame, Pairs
from followspot.transport.codec import codec_of, pack, unpack
from followspot.transport.token import ABSENT, END, MAX_WATERMARK, Watermark
from followspot.transport.wire import ALIGN, MAX_HEAD, unpack_head

INT64 = st.integers(-END, END)
TIMES = st.integers(-MAX_TIME, MAX_TIME)
HEADERS = st.builds(Header, st.text(max_size=20), st.integers(0, MAX_SEQ), TIMES, TIMES)
BOUNDS = st.integers(-MAX_WATERMARK, MAX_WATERMARK) | st.sampled_from((ABSENT, END))


class Sample(Message):
    """Every kind of scalar, and arrays whose sizes are tied to one another."""

    text: str
    count: int
    ratio: float
    flag: bool
    words: tuple[str, ...]
    values: Array = column("N", 3)
    swapped: Array = column("N", dtype=">u2")
    truth: Array = column("N", "T", dtype="?")
    wave: Array = column("T", dtype="c8")
    single: Array = column(dtype="i8")


def array(dtype: str, shape: tuple[int, ...]) -> st.SearchStrategy[Array]:
    return npst.arrays(np.dtype(dtype), shape)


@st.composite
def samples(draw: st.DrawFn) -> Sample:
    n, t = draw(st.integers(0, 5)), draw(st.integers(0, 3))
    message = Sample(
        text=draw(st.text(max_size=10)),
        count=draw(INT64),
        ratio=draw(st.floats()),
        flag=draw(st.booleans()),
        words=tuple(draw(st.lists(st.text(max_size=5), max_size=3))),
        values=draw(array("f8", (n, 3))),
        swapped=draw(array(">u2", (n,))),
        truth=draw(array("?", (n, t))),
        wave=draw(array("c8", (t,))),
        single=draw(array("i8", ())),
    )
    return stamped(seal(message), draw(HEADERS))


def blobs(n: int = 3, t: int = 2) -> Blobs:
    rng = np.random.default_rng(n)
    columns = rng.random((n, 2)), rng.random((n, 2)), rng.random(n), rng.random(n), rng.random((n, t)) > 0.5
    return stamped(seal(Blobs("cam0", *columns)), Header("camera/cam0", 7, 123456789, 42))


def without_nan(message: Message) -> Message:
    """NaN is unequal to itself; its bits are compared apart."""
    if isinstance(message, Sample):
        object.__setattr__(message, "ratio", struct.pack("<d", message.ratio))
    return message


@given(samples())
def test_any_message_arrives_bit_for_bit(message: Sample) -> None:
    arrived = unpack(pack(message), Sample)
    assert isinstance(arrived, Sample)
    assert arrived.header == message.header
    assert identical(without_nan(arrived), without_nan(message))


@given(BOUNDS)
def test_any_watermark_arrives(time: int) -> None:
    assert unpack(pack(Watermark(time)), Blobs) == Watermark(time)


def test_arrays_arrive_aligned_contiguous_and_read_only() -> None:
    arrived = unpack(pack(blobs()), Blobs)
    for array_ in codec_of(Blobs).arrays(arrived):  # type: ignore[arg-type]
        assert array_.ctypes.data % ALIGN == 0
        assert array_.flags.c_contiguous
        assert not array_.flags.writeable


def test_the_empty_message_arrives() -> None:
    for kind in (Blobs, Frame, Forecast, Pairs):
        empty = stamped(seal(kind.empty()), Header("", 0, 0))
        assert identical(unpack(pack(empty), kind), empty)  # type: ignore[arg-type]


def test_a_stranger_reads_a_message_with_msgpack_and_numpy_alone() -> None:
    """The recipe of docs/wire.md."""
    message = blobs()
    data = pack(message)
    assert data[0] == 1
    size = int.from_bytes(data[2:4], "little")
    name, source, seq, time, entered, scalars, columns = msgpack.unpackb(data[4 : 4 + size])
    start = -(-(4 + size) // 64) * 64
    arrays = {}
    for column_, dtype, shape in columns:
        count = int(np.prod(shape))
        arrays[column_] = np.frombuffer(data, dtype, count, start).reshape(shape)
        start += -(-arrays[column_].nbytes // 64) * 64
    assert start == len(data)
    assert (name, source, seq, time, entered) == ("Blobs", "camera/cam0", 7, 123456789, 42)
    assert scalars == {"camera": "cam0"}
    for field in ("xy", "pixel", "area", "similarity", "targets"):
        np.testing.assert_array_equal(arrays[field], getattr(message, field))


def tampered(**changes: object) -> bytes:
    """A packed Blobs whose head was changed: `_3=x` sets part 3."""
    message = blobs()
    head, start = unpack_head(pack(message))
    for key, value in changes.items():
        head[int(key[1:])] = value
    raw: bytes = msgpack.packb(head)
    size = 4 + len(raw)
    return struct.pack("<BxH", 1, len(raw)) + raw + bytes(-size % 64) + pack(message)[start:]


def columns_of(message: Message) -> list[list[object]]:
    head, _ = unpack_head(pack(message))
    return head[6]  # type: ignore[no-any-return]


def with_row(index: int, row: object) -> list[object]:
    rows: list[object] = list(columns_of(blobs()))
    rows[index] = row
    return rows


WRONG_HEADS: dict[str, tuple[dict[str, object], str]] = {
    "another type": ({"_0": "Frame"}, "expected Blobs"),
    "number beyond 64 bits": ({"_2": 2**64 - 1}, "header"),
    "source of a novel's length": ({"_1": "a" * 1001}, "1001 characters"),
    "source is a number": ({"_1": 5}, "header"),
    "sequence is text": ({"_2": "7"}, "header"),
    "time is a fraction": ({"_3": 0.5}, "header"),
    "time beyond the end": ({"_3": END + 1}, "header"),
    "entered is a switch": ({"_4": True}, "header"),
    "scalar missing": ({"_5": {}}, "scalars"),
    "scalar of another name": ({"_5": {"cam": "cam0"}}, "camera"),
    "scalar of another type": ({"_5": {"camera": 5}}, "camera is an int, declared str"),
    "a list for a text": ({"_5": {"camera": ["cam0"]}}, "camera is a list, declared str"),
    "surplus scalar": ({"_5": {"camera": "cam0", "more": 1}}, "scalars"),
    "columns missing": ({"_6": []}, "columns"),
    "column of another name": ({"_6": with_row(0, ["yx", "<f8", [3, 2]])}, "xy"),
    "column of another dtype": ({"_6": with_row(0, ["xy", "<f4", [3, 2]])}, "dtype"),
    "an object dtype": ({"_6": with_row(0, ["xy", "|O", [3, 2]])}, "dtype"),
    "negative size": ({"_6": with_row(0, ["xy", "<f8", [-3, 2]])}, "impossible shape"),
    "size is a switch": ({"_6": with_row(0, ["xy", "<f8", [True, 2]])}, "impossible shape"),
    "another number of dimensions": ({"_6": with_row(0, ["xy", "<f8", [3, 2, 1]])}, "shape"),
    "fixed size differs": ({"_6": with_row(0, ["xy", "<f8", [3, 3]])}, "shape"),
    "named sizes disagree": ({"_6": with_row(2, ["area", "<f8", [4]])}, "shape"),
    "a huge size": ({"_6": with_row(4, ["targets", "|b1", [3, 2**40]])}, "more than"),
    "a huge size beside 0": ({"_6": with_row(4, ["targets", "|b1", [0, 2**40]])}, "more than"),
}


@pytest.mark.parametrize("case", WRONG_HEADS)
def test_a_wrong_head_is_invalid_and_named(case: str) -> None:
    changes, reason = WRONG_HEADS[case]
    with pytest.raises(InvalidMessage, match=reason):
        unpack(tampered(**changes), Blobs)


def test_a_wrong_size_is_invalid() -> None:
    data = pack(blobs())
    for wrong in (b"", data[:3], data[:40], data[:-64], data[:-1], data + bytes(64), data + b"\0"):
        with pytest.raises(InvalidMessage):
            unpack(wrong, Blobs)
    with pytest.raises(InvalidMessage, match="watermark"):
        unpack(pack(Watermark(5)) + bytes(64), Blobs)


def test_another_version_is_invalid_and_both_are_named() -> None:
    with pytest.raises(InvalidMessage, match="wire format 2, this is 1"):
        unpack(b"\x02" + pack(blobs())[1:], Blobs)


def test_arrays_that_are_coded_are_not_taken_for_numbers() -> None:
    packed = pack(blobs())
    with pytest.raises(InvalidMessage, match="coded in way 3"):
        unpack(packed[:1] + b"\3" + packed[2:], Blobs)


def test_truth_values_other_than_0_and_1_are_invalid() -> None:
    data = bytearray(pack(blobs()))
    data[-64] = 2
    with pytest.raises(InvalidMessage, match="truth"):
        unpack(bytes(data), Blobs)


def test_a_head_over_the_limit_is_refused_by_the_sender() -> None:
    names = tuple("c" * 1000 for _ in range(66))
    with pytest.raises(InvalidMessage, match=f"at most {MAX_HEAD}"):
        pack(
            stamped(Pairs(names, *(getattr(Pairs.empty(), c.name) for c in Pairs.columns)), Header("", 0, 0))
        )


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32))
def test_ten_thousand_mutated_messages_are_invalid_or_valid_never_a_crash(seed: int) -> None:
    """500 mutations of each of 20 examples: bits flipped, pieces cut, doubled and overwritten."""
    rng = random.Random(seed)
    originals = [pack(blobs()), pack(blobs(0, 0)), pack(Watermark(12))]
    for _ in range(500):
        data = bytearray(rng.choice(originals))
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(min(len(data), rng.choice((8, 160, 10**6))) or 1)
            match rng.randrange(4):
                case 0:
                    data[at : at + 1] = bytes([rng.randrange(256)])
                case 1:
                    data[at : at + rng.randint(1, 80)] = b""
                case 2:
                    data[at:at] = data[at : at + rng.randint(1, 80)]
                case _:
                    data[at : at + 4] = rng.randbytes(4)
        with contextlib.suppress(InvalidMessage):
            assert isinstance(unpack(bytes(data), Blobs), Blobs | Watermark)


def test_a_scalar_of_numpy_is_a_plain_one_on_every_kind_of_edge() -> None:
    forecast = seal(Forecast(np.float32(0.5), *(getattr(Forecast.empty(), c.name) for c in Forecast.columns)))  # type: ignore[arg-type]
    assert type(forecast.period) is float
    with pytest.raises(InvalidMessage, match="period is a str"):
        seal(Forecast("soon", *(getattr(Forecast.empty(), c.name) for c in Forecast.columns)))  # type: ignore[arg-type]
