"""Packets by UDP: in order again, whatever overtook what, however long others stay away."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from followspot_cameras.rtsp import jitter_buffer
from followspot_cameras.rtsp.jitter_buffer import JitterBuffer

WAIT = 100


def taken(buffer: JitterBuffer[int], now: int) -> list[int]:
    found = []
    while (packet := buffer.next(now)) is not None:
        found.append(packet)
    return found


def test_packets_in_order_are_not_held() -> None:
    buffer: JitterBuffer[int] = JitterBuffer(WAIT)
    for number in range(5):
        buffer.add(number, number, now=number)
        assert taken(buffer, now=number) == [number]
    assert not buffer.holds


@given(st.permutations(range(1, 40)), st.integers(0, 0xFFFF))
def test_all_packets_come_in_order_if_none_is_waited_for_too_long(order: list[int], first: int) -> None:
    buffer: JitterBuffer[int] = JitterBuffer(WAIT)
    found = []
    for now, number in enumerate([0, *order]):
        buffer.add((first + number) & 0xFFFF, number, now)
        found += taken(buffer, now)
    assert found == list(range(40))
    assert buffer.late == 0


def test_a_missing_packet_is_waited_for_and_then_given_up() -> None:
    buffer: JitterBuffer[int] = JitterBuffer(WAIT)
    buffer.add(0xFFFF, -1, now=0)
    buffer.add(1, 1, now=10)
    buffer.add(2, 2, now=50)
    assert taken(buffer, now=9 + WAIT) == [-1]
    assert buffer.due == 10 + WAIT
    assert taken(buffer, now=10 + WAIT) == [1, 2]
    buffer.add(0, 0, now=11 + WAIT)
    assert taken(buffer, now=1000) == []
    assert buffer.late == 1


def test_a_packet_that_comes_twice_counts_once() -> None:
    buffer: JitterBuffer[int] = JitterBuffer(WAIT)
    for number in (0, 0, 2, 2, 1):
        buffer.add(number, number, now=0)
    assert taken(buffer, now=0) == [0, 1, 2]
    assert buffer.late == 2


def test_each_missing_packet_is_waited_for_from_when_it_was_overtaken() -> None:
    buffer: JitterBuffer[int] = JitterBuffer(WAIT)
    for number, now in ((0, 0), (2, 10), (4, 60)):
        buffer.add(number, number, now)
    assert taken(buffer, now=10 + WAIT) == [0, 2]
    assert taken(buffer, now=60 + WAIT) == [4]


def test_a_sender_that_counts_anew_is_followed() -> None:
    buffer: JitterBuffer[int] = JitterBuffer(WAIT)
    for number in (5000, 5001, 7, 8):
        buffer.add(number, number, now=0)
        assert taken(buffer, now=0) == [number]


def test_memory_is_bounded() -> None:
    buffer: JitterBuffer[int] = JitterBuffer(10**12)
    buffer.add(0, 0, now=0)
    found = taken(buffer, now=0)
    for number in range(2, jitter_buffer.MOST_HELD + 3):
        buffer.add(number, number, now=0)
        found += taken(buffer, now=0)
    assert len(found) == 1 + jitter_buffer.MOST_HELD + 1
