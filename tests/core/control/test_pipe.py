"""The control channel between a host and a worker: complete messages, in order, with their descriptors."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator

import pytest

from followspot.control.lifecycle import EndWorkers, StartRun, StopRun
from followspot.control.pipe import MAX_DESCRIPTORS, MAX_WAITING, Channel, ChannelClosed
from followspot.control.worker_orders import ORDERS, TakeRing


@pytest.fixture
def ends() -> Iterator[tuple[Channel, Channel]]:
    one, other = (Channel(end, ORDERS) for end in socket.socketpair())
    yield one, other
    one.close()
    other.close()


def test_requests_that_arrived_with_an_earlier_one_are_buffered(ends: tuple[Channel, Channel]) -> None:
    one, other = ends
    assert not other.waits(0.0)
    one.send(StartRun())
    one.send(EndWorkers(workers=("a",)))
    assert other.waits(60.0)
    assert other.receive().request == StartRun()
    assert other.waits(0.0), "the second is here already"
    assert [request for request, _ in other.buffered()] == [EndWorkers(workers=("a",))]
    assert not other.waits(0.0)


def test_descriptors_without_a_message_are_limited_to_those_of_all_rings(
    ends: tuple[Channel, Channel],
) -> None:
    one, other = ends
    read, write = os.pipe()
    try:
        for _ in range(MAX_WAITING // MAX_DESCRIPTORS):
            socket.send_fds(one.socket, [b" "], [read] * MAX_DESCRIPTORS)
            assert other.arrived() == []
        socket.send_fds(one.socket, [b" "], [read])
        with pytest.raises(ValueError, match="more than 1024 descriptors without a message"):
            other.arrived()
    finally:
        os.close(read)
        os.close(write)


def test_the_other_end_closes_the_channel(ends: tuple[Channel, Channel]) -> None:
    one, other = ends
    one.send(StopRun())
    one.close()
    assert other.receive().request == StopRun()
    with pytest.raises(ChannelClosed):
        other.receive()


def test_descriptors_travel_beside_the_request_they_were_sent_with(
    ends: tuple[Channel, Channel],
) -> None:
    one, other = ends
    read, write = os.pipe()
    order = TakeRing(edge=3, side="sending")
    one.send(order, (write,))
    one.send(StartRun())
    os.close(write)
    found, (descriptor,) = other.receive()
    assert found == order
    assert other.receive() == (StartRun(), [])
    os.write(descriptor, b"a")
    assert os.read(read, 1) == b"a"
    os.close(descriptor)
    os.close(read)


def test_a_channel_rejects_unknown_requests(ends: tuple[Channel, Channel]) -> None:
    one, other = ends
    one.socket.sendall(b'{"verb": "dance"}\n')
    with pytest.raises(ValueError, match="there is no request 'dance'"):
        other.receive()
