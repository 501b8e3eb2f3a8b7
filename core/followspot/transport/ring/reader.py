"""The reading end of the ring: messages whose arrays are views of the writer's memory."""

from __future__ import annotations

import contextlib
import mmap
import os
import socket
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from followspot.errors import FollowspotError
from followspot.messages import Array, InvalidMessage, Message
from followspot.transport.codec import codec_of
from followspot.transport.ring.control import ARENAS, Control, fence
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import (
    ARENA,
    HELLO,
    INLINE,
    INLINE_BYTES,
    MAX_SLOT,
    MAX_SLOTS,
    NOTIFICATION,
    SLOT,
    WATERMARK,
)
from followspot.transport.ring.slots import Arena, Lease
from followspot.transport.token import END, MAX_COUNT, Invalid, Token, Watermark, is_watermark
from followspot.transport.wire import MAX_HEAD, aligned, unpack_head

_LARGEST = NOTIFICATION.size + MAX_HEAD + 2 * INLINE_BYTES
_ANCILLARY, _FLAGS = socket.CMSG_LEN(4), socket.MSG_CMSG_CLOEXEC
"""A datagram may bring one file descriptor."""
_NONE = (0, 0, 0, 0, 0)
_BATCH = 256
"""Most datagrams that one poll takes, so that a flood of watermarks does not hold up the worker."""
_MOST_MISSING = 256
"""Most messages that may be missing before one; a socket loses none, so a larger gap is refused."""


class RingReader:
    """`PortReader` on the writer's host.

    The arrays of a message are read-only views; the slot is released when the last of them dies. A stage may
    keep any number of messages: beyond its share of the slots, it gets copies.
    """

    def __init__(self, sock: socket.socket, kind: type[Message]) -> None:
        """sock: the other end of the writer's socket; kind: type of the messages."""
        sock.setblocking(False)
        self._socket = sock
        self._buffer = memoryview(bytearray(_LARGEST))
        self._codec = codec_of(kind)
        self._control: Control | None = None
        self._arena: Arena | None = None
        self._interfaces: list[dict[str, Any]] = []
        self._slots = 0
        self._quota = 0
        self._leased: set[tuple[int, int]] = set()
        self._sequence = 0
        self._received = 0
        self._consumed = 0
        self._ended = False
        self._closed = False
        self._refused = 0

    @property
    def strangers(self) -> int:
        """How many datagrams came that no writer sends."""
        return self._refused

    @property
    def lost(self) -> bool:
        """Whether the writer is gone without having ended the stream."""
        return self._closed and not self._ended

    @property
    def broken(self) -> bool:
        """Whether the writer is gone: its replacement has another socket."""
        return self._closed

    def matched(self) -> bool:
        """True: the socket exists before the processes do."""
        return True

    def fileno(self) -> int:
        """The socket."""
        return self._socket.fileno()

    def poll(self) -> list[Token]:
        """Tokens that have arrived, at most 256 datagrams at once.

        Raises FollowspotError if memory cannot be mapped.
        """
        tokens: list[Token] = []
        for _ in range(_BATCH):
            try:
                size, extra, _, _ = self._socket.recvmsg_into([self._buffer], _ANCILLARY, _FLAGS)
            except BlockingIOError:
                break
            except ConnectionResetError:
                continue  # the writer left wake-ups unread; its datagrams are still there
            except OSError:
                size = 0
            if not size:
                self._closed = True
                break
            self._received += 1
            self._accept(self._buffer[:size], extra, tokens)
            if self._control is not None and self._received >= self._control.sent:
                break
        self._wake()
        return tokens

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that left the queue."""
        if self._control is not None:
            self._consumed += count
            self._control.consumed = self._consumed
            fence()
            self._wake()

    def close(self) -> None:
        """Close the socket; messages that a stage still holds stay valid, and release their slots later."""
        self._socket.close()

    def _accept(self, data: memoryview, extra: Sequence[tuple[int, int, bytes]], tokens: list[Token]) -> None:
        """Append the token of one datagram; extra: the file descriptor that it brought, if any."""
        whole = len(data) >= NOTIFICATION.size
        kind, number, slot, size, value = NOTIFICATION.unpack_from(data) if whole else _NONE
        if kind in (INLINE, SLOT) and not extra and 0 <= value - self._sequence <= _MOST_MISSING:
            missing = range(self._sequence, value)
            tokens += [Invalid(f"gap: message {n} of the port never came", missing=True) for n in missing]
            self._sequence = value + 1
            try:
                inline = kind == INLINE
                tokens.append(self._inline(data, size) if inline else self._placed(data, number, slot, size))
            except InvalidMessage as error:
                tokens.append(Invalid(str(error)))
        elif kind == WATERMARK and not extra and is_watermark(value):
            self._ended = value == END
            tokens.append(Watermark(value))
        elif not (extra and self._mapped(extra[0][2], kind, number, slot, size, value)):
            self._refused += 1

    def _inline(self, data: memoryview, size: int) -> Message:
        head, start = unpack_head(data[NOTIFICATION.size :])
        start += NOTIFICATION.size
        if len(data) != start + size:
            raise InvalidMessage(f"{size} bytes of arrays announced, {len(data) - start} came")
        body = aligned(size)
        body[:] = np.frombuffer(data, np.uint8, size, start)
        return self._codec.decode(head, body)

    def _placed(self, data: memoryview, number: int, slot: int, size: int) -> Message:
        body = self._body(number, slot, size)
        head, start = unpack_head(data[NOTIFICATION.size :])
        return self._codec.decode(head, body, data[NOTIFICATION.size + start :])

    def _body(self, number: int, slot: int, size: int) -> Array:
        """The slot, leased, as bytes; a copy of its first `size` if this reader has its share of leases."""
        arena = self._arena
        if arena is None or number != arena.number or slot >= len(self._interfaces) or size > arena.capacity:
            raise InvalidMessage(f"{size} bytes in slot {slot} of arena {number}, which does not exist")
        lease = Lease(arena, slot, self._sequence, self._interfaces[slot], self._release)
        if len(self._leased) < self._quota:
            self._leased.add((number, slot))
            return np.asarray(lease)
        body = aligned(size)
        body[:] = arena.bytes[slot, :size]
        return body

    def _release(self, lease: Lease) -> None:
        """Release the message in a slot. Its stamp is its sequence number + 1."""
        if self._control is not None:
            self._control.release(lease.arena.number, lease.slot, lease.stamp)
        self._leased.discard((lease.arena.number, lease.slot))
        fence()
        self._wake()

    def _mapped(self, packed: bytes, kind: int, number: int, slot: int, size: int, value: int) -> bool:
        """Map the memory that a datagram brought; False if it is not what the datagram claims.

        packed: the file descriptor. Raises FollowspotError if there is no memory to map it.
        """
        fd = int.from_bytes(packed, sys.byteorder)
        if not self._credible(kind, number, slot, size, value):
            os.close(fd)
            return False
        try:
            if kind == HELLO:
                self._control = Control(Memory(fd, Control.size(size), writable=True), size)
                self._quota, self._slots = slot, size
                self._sequence = self._consumed = value
            else:
                self._enter(
                    Arena(Memory(fd, self._slots * value, writable=False), number, self._slots, value)
                )
        except ValueError:
            return False
        except OSError as error:
            raise FollowspotError(f"the memory of an edge cannot be mapped: {error}") from None
        return True

    def _credible(self, kind: int, number: int, slot: int, size: int, value: int) -> bool:
        """Whether a writer sends this: one HELLO, and arenas each newer than the one before."""
        if kind == HELLO:
            return (
                self._control is None and slot <= size and 0 < size <= MAX_SLOTS and 0 <= value <= MAX_COUNT
            )
        newest = -1 if self._arena is None else self._arena.number
        whole = 0 < value <= MAX_SLOT and value % mmap.PAGESIZE == 0
        return kind == ARENA and self._control is not None and newest < number < ARENAS and whole

    def _enter(self, arena: Arena) -> None:
        """Find messages in this arena from now on."""
        one = (arena.capacity,)
        self._arena = arena
        self._interfaces = [arena.interface(i, one, "|u1", writable=False) for i in range(self._slots)]

    def _wake(self) -> None:
        """Wake the writer if it asked for that."""
        if self._control is not None and self._control.waiting:
            self._control.waiting = False
            with contextlib.suppress(OSError):  # a full socket wakes the writer anyway, a closed one has none
                self._socket.send(b"\1")
