"""The least that two processes need to pass arrays in Python: shared slots, and datagrams on a socket pair.

`bench/runtime/edges.py` compares with it. It knows one shape, checks nothing, survives no death, has one
reader, which may keep no message, and knows neither types nor watermarks.
"""

from __future__ import annotations

import mmap
import os
import socket
from math import prod
from struct import Struct
from typing import NamedTuple

import numpy as np

from followspot.messages import Array

SLOTS = 8
"""Messages that may be under way."""
SMALL = 4096
"""Most bytes that travel in the datagram."""
_HEAD = Struct("<qq")
"""Number of the message, and when it was complete, ns."""
_CONSUMED, _WAITING, _CONTROL = 0, 1, mmap.PAGESIZE


class Arrived(NamedTuple):
    """A message; number -1 is the end. entered: when it was complete, ns."""

    number: int
    entered: int
    array: Array


class _Slots:
    """Memory of both processes: words, and a slot for each message that may be under way."""

    def __init__(self, fd: int, shape: tuple[int, ...]) -> None:
        size = prod(shape)
        self.memory = mmap.mmap(fd, memory_size(shape))
        self.words = memoryview(self.memory).cast("Q")
        self.small = size <= SMALL
        self.arrays = [
            np.ndarray(shape, np.uint8, self.memory, _CONTROL + slot * _rounded(size))
            for slot in range(SLOTS)
        ]


class BareWriter:
    """The sending end."""

    def __init__(self, sock: socket.socket, fd: int, shape: tuple[int, ...]) -> None:
        sock.setblocking(False)
        self._socket = sock
        self._slots = _Slots(fd, shape)
        self._sent = 0

    def credit(self) -> int:
        """Messages that may be sent now."""
        return int(self._slots.words[_CONSUMED]) + SLOTS - self._sent

    def loan(self) -> Array:
        """Where the next message may be written."""
        return self._slots.arrays[self._sent % SLOTS]

    def send(self, array: Array, entered: int) -> None:
        """Send an array that was lent, or a small one."""
        rest = array.tobytes() if self._slots.small else b""
        self._socket.send(_HEAD.pack(self._sent, entered) + rest)
        self._sent += 1

    def end(self) -> None:
        """Say that nothing follows."""
        self._socket.send(_HEAD.pack(-1, 0))

    def want_credit(self) -> None:
        """Ask for a wake-up at the next credit."""
        self._slots.words[_WAITING] = 1

    def filenos(self) -> list[int]:
        """What becomes readable then."""
        return [self._socket.fileno()]

    def drain(self) -> None:
        """Clear wake-ups."""
        try:
            self._socket.recv(64)
        except BlockingIOError:
            return


class BareReader:
    """The receiving end."""

    def __init__(self, sock: socket.socket, fd: int, shape: tuple[int, ...]) -> None:
        sock.setblocking(False)
        self._socket = sock
        self._slots = _Slots(fd, shape)
        self._shape = shape
        self._consumed = 0

    def fileno(self) -> int:
        """The socket."""
        return self._socket.fileno()

    def poll(self) -> list[Arrived]:
        """The next message, if it is there."""
        try:
            data = self._socket.recv(_HEAD.size + SMALL)
        except BlockingIOError:
            return []
        number, entered = _HEAD.unpack_from(data)
        if self._slots.small and number >= 0:
            return [Arrived(number, entered, np.ndarray(self._shape, np.uint8, data, _HEAD.size))]
        return [Arrived(number, entered, self._slots.arrays[number % SLOTS])]

    def consumed(self) -> None:
        """Give credit for one message."""
        self._consumed += 1
        words = self._slots.words
        words[_CONSUMED] = self._consumed
        if words[_WAITING]:
            words[_WAITING] = 0
            self._socket.send(b"\1")


def create(shape: tuple[int, ...]) -> int:
    """The descriptor of memory for arrays of this shape, of uint8."""
    fd = os.memfd_create("bare-ring")
    os.ftruncate(fd, memory_size(shape))
    return fd


def memory_size(shape: tuple[int, ...]) -> int:
    """Bytes that both processes map."""
    return _CONTROL + SLOTS * _rounded(prod(shape))


def _rounded(size: int) -> int:
    return -(-size // mmap.PAGESIZE) * mmap.PAGESIZE
