"""The fixtures that every plugin's tests have."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from followspot import Message, Room
from followspot.messages import InvalidMessage, identical
from followspot.testing import MemoryEdge, VirtualClock
from followspot.testing.samples import BLACK, sample
from followspot.tracking import Blobs, Frame


def test_a_virtual_clock_stamps_frames_and_goes_when_told(virtual_clock: VirtualClock) -> None:
    first = virtual_clock.stamp(Frame("cam0", BLACK.copy()))
    virtual_clock.tick(3)
    later = virtual_clock.stamp(Frame("cam0", BLACK.copy()))
    assert (later.header.seq - first.header.seq, later.header.time - first.header.time) == (
        3,
        100_000_000 - 1,
    )
    assert not later.pixels.flags.writeable


def test_what_a_memory_edge_delivers_is_another_object_with_the_same_bits(
    memory_edge: Callable[[type[Message]], MemoryEdge], tiny_room: Room, virtual_clock: VirtualClock
) -> None:
    edge = memory_edge(Blobs)
    sent = virtual_clock.stamp(sample(Blobs, "plausible", tiny_room, "cam0", BLACK))
    arrived = edge.send(sent)
    assert arrived is not sent
    assert identical(arrived, sent)
    assert edge.arrived == [arrived]


def test_a_memory_edge_refuses_what_breaks_its_contract(
    memory_edge: Callable[[type[Message]], MemoryEdge], virtual_clock: VirtualClock
) -> None:
    with pytest.raises(InvalidMessage):
        memory_edge(Blobs).send(virtual_clock.stamp(Frame("cam0", BLACK.copy())))
