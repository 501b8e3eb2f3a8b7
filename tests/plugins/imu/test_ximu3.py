"""x-IMU3: the examples of its manual, a sender that follows it, losses, and datagrams that are none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.plugins.imu.network import AtWork
from tests.plugins.imu.ximu3_messages import binary

from followspot_imu.network.ximu3 import Ximu3
from followspot_imu.network.ximu3_messages import LONGEST, Malformed, Ximu3Message, Ximu3Stream, message

MANUAL = {
    "I,1000000,0.0000,0.0000,0.0000,0.0000,0.0000,1.0000\r": Ximu3Message("I", 1_000_000, (0, 0, 0, 0, 0, 1)),
    "M,1000000,1.0000,0.0000,0.0000\r": Ximu3Message("M", 1_000_000, (1, 0, 0)),
    "C9 40 42 0F 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 80 3F": (
        Ximu3Message("I", 1_000_000, (0, 0, 0, 0, 0, 1))
    ),
    "CD 40 42 0F 00 00 00 00 00 00 00 80 3F 00 00 00 00 00 00 00 00": Ximu3Message("M", 1_000_000, (1, 0, 0)),
}
"""The examples of the user manual, without the line feed at the end."""


@pytest.mark.parametrize(("example", "meant"), MANUAL.items())
def test_the_examples_of_the_manual_are_read(example: str, meant: Ximu3Message) -> None:
    data = bytes.fromhex(example) if example[1] != "," else example.encode()
    assert message(data) == meant
    assert message(data.rstrip(b"\r")) == meant


def ascii_message(letter: str, time: int, *numbers: float) -> bytes:
    return f"{letter},{time},{','.join(f'{number:.4f}' for number in numbers)}\r\n".encode()


@given(
    st.integers(0, 1 << 52),
    st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=6, max_size=6),
)
@settings(max_examples=100, deadline=None)
def test_every_binary_message_is_read_back_also_in_pieces(time: int, numbers: list[float]) -> None:
    data = binary("I", time, *numbers)
    assert data.count(b"\x0a") == 1
    wanted = Ximu3Message("I", time, tuple(numbers))
    assert message(data[:-1]) == wanted
    stream = Ximu3Stream()
    found = [one for at in range(0, len(data), 5) for one in stream.messages(data[at : at + 5])]
    assert found == [wanted]


def test_a_lost_datagram_costs_no_message_of_the_next() -> None:
    stream, whole = Ximu3Stream(), binary("I", 7, 1, 2, 3, 4, 5, 6)
    assert list(stream.messages(whole + whole[:11])) == [message(whole[:-1])]
    broken, again, other = stream.messages(whole + whole)
    assert isinstance(broken, Malformed)
    assert again == other == message(whole[:-1])


@given(st.binary(max_size=300))
@settings(max_examples=200, deadline=None)
def test_any_bytes_give_messages_or_reasons(data: bytes) -> None:
    stream = Ximu3Stream()
    for part in (data, data[::-1], b"\n"):
        for found in stream.messages(part):
            assert isinstance(found, Ximu3Message | Malformed)
    assert list(stream.messages(b"N,1,hello\n")) == [Ximu3Message("N")]


def test_a_stream_without_line_feeds_takes_no_memory() -> None:
    stream = Ximu3Stream()
    told = [found for _ in range(100) for found in stream.messages(b"x" * 1000)]
    assert len(told) == 100_000 // (LONGEST + 1 + 1000 - LONGEST % 1000 - 1)
    assert len(stream._begun) <= LONGEST


@pytest.mark.parametrize("write", [binary, ascii_message])
def test_readings_come_in_si_units_with_the_intervals_of_the_device(write: object) -> None:
    with AtWork(Ximu3, axes="y -x z", batch_time=10.0, batch=4) as work:
        work.send(write("M", 4_999_000, 0.5, 0, -1))  # type: ignore[operator]
        for k in range(12):
            work.send(write("Q", k, 1, 0, 0, 0) + write("I", 5_000_000 + 2500 * k, 180, k, 0, 0, 0, 1))  # type: ignore[operator]
    assert [len(sent.time) for sent in work.sent] == [4, 4, 4]
    assert np.diff(work.column("time")).min() >= 1
    late = work.column("time") - work.column("time")[0] - 2_500_000 * np.arange(12)
    assert (late <= 0).all()  # a datagram that took less time shifts what follows back, never forth
    np.testing.assert_allclose(work.column("turn_rate")[3], [np.radians(3), -np.pi, 0])
    np.testing.assert_allclose(work.column("specific_force")[3], [0, 0, 9.80665])
    np.testing.assert_allclose(work.column("field")[0], [0, -25, -50])
    assert np.isnan(work.column("field")[1:]).all()
    assert not work.told


def test_what_a_device_tells_is_warned_of_on_one_line_without_control_characters() -> None:
    with AtWork(Ximu3) as work:
        work.send(b"F,123,\x1b[2J\x1b]0;mine\x07 all is well\r\n")
    assert r"\x1b[2J\x1b]0;mine\x07 all is well" in work.told[0]
    assert all(text.isprintable() for text in work.told)
