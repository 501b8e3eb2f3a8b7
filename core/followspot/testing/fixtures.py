"""Fixtures for the tests of plugins; pytest finds them once followspot is installed."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from followspot.messages import Message
from followspot.room import Room
from followspot.testing.clock import MemoryEdge, VirtualClock
from followspot.testing.tiny_room import tiny_room as make_tiny_room


@pytest.fixture
def tiny_room() -> Room:
    """Two cameras, a floor, one red ball: `followspot.testing.tiny_room`."""
    return make_tiny_room()


@pytest.fixture
def virtual_clock() -> VirtualClock:
    """A clock of 30 frames per second that goes when the test says so."""
    return VirtualClock()


@pytest.fixture
def memory_edge() -> Callable[[type[Message]], MemoryEdge]:
    """Makes an edge to another process without the process: `memory_edge(Blobs).send(message)`."""
    return MemoryEdge
