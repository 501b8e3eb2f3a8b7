"""The same arrays over iceoryx2: slices in its shared memory, and its events as wake-ups.

`bench/runtime/edges.py` compares with it. As the bare ring it knows one shape and no types. A listener of
the Python package has no file descriptor, so a reader waits for it alone.
"""

from __future__ import annotations

import ctypes
from math import prod
from struct import Struct
from typing import Any

import iceoryx2 as iox
import numpy as np

from benching.bare_ring import SLOTS, Arrived
from followspot.messages import Array

_HEAD = Struct("<qq48x")
"""Number of the message, and when it was complete, ns; as long as a line of the cache."""
_LONGEST = 100
"""Longest sleep, ms."""


def _service(name: str) -> tuple[Any, Any, Any]:
    """The node, the messages and the events of an edge."""
    iox.set_log_level(iox.LogLevel.Error)
    node = iox.NodeBuilder.new().create(iox.ServiceType.Ipc)
    messages = node.service_builder(iox.ServiceName.new(name)).publish_subscribe(iox.Slice[ctypes.c_uint8])
    messages = messages.enable_safe_overflow(False).subscriber_max_buffer_size(SLOTS)
    events = node.service_builder(iox.ServiceName.new(name)).event()
    return node, messages.subscriber_max_borrowed_samples(SLOTS).open_or_create(), events.open_or_create()


class IceoryxWriter:
    """The sending end; a call waits while the reader has no room."""

    def __init__(self, name: str, shape: tuple[int, ...]) -> None:
        self._node, messages, events = _service(name)
        self._shape, self._size, self._sent = shape, _HEAD.size + prod(shape), 0
        self._publisher = messages.publisher_builder().initial_max_slice_len(self._size).create()
        self._notifier = events.notifier_builder().create()
        self._loan: Any = None

    def loan(self) -> Array:
        """Where the next message may be written."""
        self._loan = self._publisher.loan_slice_uninit(self._size)
        return np.ndarray(self._shape, np.uint8, _memory(self._loan), _HEAD.size)

    def send(self, entered: int) -> None:
        """Send what was lent last."""
        _HEAD.pack_into(_memory(self._loan), 0, self._sent, entered)
        self._loan.assume_init().send()
        self._notifier.notify()
        self._loan = None
        self._sent += 1

    def end(self) -> None:
        """Say that nothing follows."""
        self._sent = -1
        self.loan()
        self.send(0)


class IceoryxReader:
    """The receiving end."""

    def __init__(self, name: str, shape: tuple[int, ...]) -> None:
        self._node, messages, events = _service(name)
        self._shape = shape
        self._subscriber = messages.subscriber_builder().buffer_size(SLOTS).create()
        self._listener = events.listener_builder().create()
        self._held: Any = None

    def wait(self) -> None:
        """Until something may have come."""
        self._listener.timed_wait(iox.Duration.from_millis(_LONGEST))

    def poll(self) -> list[Arrived]:
        """The next message, if it is there."""
        sample = self._subscriber.receive()
        if sample is None:
            return []
        self._held = sample
        memory = _memory(sample)
        number, entered = _HEAD.unpack_from(memory)
        return [Arrived(number, entered, np.ndarray(self._shape, np.uint8, memory, _HEAD.size))]

    def consumed(self) -> None:
        """Give the slot of the message back."""
        self._held.delete()
        self._held = None


def _memory(sample: Any) -> memoryview:
    found: memoryview = sample.payload().as_memory_view()
    return found
