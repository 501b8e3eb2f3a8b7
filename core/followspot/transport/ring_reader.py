"""The reading end of the ring: messages whose arrays are views of the writer's memory."""

from __future__ import annotations

import contextlib
import socket
from functools import partial

import numpy as np

from followspot.messages import Array, InvalidMessage, Message
from followspot.transport.codec import codec_of
from followspot.transport.control import ARENAS, Control, fence
from followspot.transport.doorbell import ARENA, DOORBELL, HELLO, INLINE, INLINE_BYTES, SETTLED, SLOT
from followspot.transport.memory import Memory
from followspot.transport.slots import Arena, Lease
from followspot.transport.token import END, Invalid, Settled, Token
from followspot.transport.wire import MAX_HEAD, aligned, unpack_head

_LARGEST = DOORBELL.size + MAX_HEAD + 2 * INLINE_BYTES
_BATCH = 256
"""Most datagrams that one poll takes; a flood of settled times must not hold up the worker."""


class RingReader:
    """`PortReader` on the writer's host.

    The arrays of a message are read-only views; the slot is released when the last of them dies. A stage may
    keep as many as it likes: over its share of the slots, it gets copies.
    """

    def __init__(self, sock: socket.socket, kind: type[Message]) -> None:
        """sock: the other end of the writer's socket; kind: type of the messages."""
        sock.setblocking(False)
        self._socket = sock
        self._codec = codec_of(kind)
        self._control: Control | None = None
        self._arena: Arena | None = None
        self._number = 0
        self._slots = 0
        self._quota = 0
        self._held: set[tuple[int, int]] = set()
        self._sequence = 0
        self._consumed = 0
        self._ended = False
        self._closed = False

    @property
    def lost(self) -> bool:
        """Whether the writer is gone without an end."""
        return self._closed and not self._ended

    def matched(self) -> bool:
        """True: the socket exists before the processes do."""
        return True

    def fileno(self) -> int:
        """The socket."""
        return self._socket.fileno()

    def poll(self) -> list[Token]:
        """Everything that has arrived, at most 256 datagrams at once."""
        tokens: list[Token] = []
        for _ in range(_BATCH):
            try:
                data, fds, _, _ = socket.recv_fds(self._socket, _LARGEST, 1, socket.MSG_CMSG_CLOEXEC)
            except BlockingIOError:
                break
            except ConnectionResetError:
                continue  # the writer left wake-ups unread; what it sent is still there
            except OSError:
                data = b""
            if not data:
                self._closed = True
                break
            self._accept(data, fds, tokens)
        self._wake()
        return tokens

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that were taken out of the queue."""
        if self._control is not None:
            self._consumed += count
            self._control.consumed = self._consumed
            self._wake()

    def close(self) -> None:
        """Close the socket; messages in other hands stay valid, and release their slots when they die."""
        self._socket.close()

    def _accept(self, data: bytes, fds: list[int], tokens: list[Token]) -> None:
        """Append what one datagram says."""
        kind, number, slot, size, value = DOORBELL.unpack_from(data.ljust(DOORBELL.size, b"\0"))
        if kind == SETTLED:
            self._ended = value == END
            tokens.append(Settled(value))
        elif kind in (INLINE, SLOT):
            if value != self._sequence:
                tokens.append(self._gap(value - self._sequence))
            self._sequence = value + 1
            try:
                tokens.append(
                    self._inline(data, size) if kind == INLINE else self._placed(data, number, slot, size)
                )
            except InvalidMessage as error:
                tokens.append(Invalid(str(error)))
                self.consumed()
        elif kind in (HELLO, ARENA) and fds:
            try:
                self._map(fds[0], kind, number, slot, size, value)
            except (OSError, ValueError, OverflowError) as error:
                tokens.append(Invalid(f"shared memory cannot be used: {error}"))
        else:
            tokens.append(Invalid(f"a datagram of kind {kind} and {len(data)} bytes"))

    def _gap(self, missing: int) -> Invalid:
        """Report messages that never came, and give their credit back."""
        self.consumed(max(0, missing))
        return Invalid(f"gap: expected message {self._sequence}, {missing} are missing")

    def _inline(self, data: bytes, size: int) -> Message:
        head, start = unpack_head(data[DOORBELL.size :])
        start += DOORBELL.size
        if len(data) != start + size:
            raise InvalidMessage(f"{size} bytes of arrays announced, {len(data) - start} came")
        body = aligned(size)
        body[:] = np.frombuffer(data, np.uint8, size, start)
        return self._codec.decode(head, body)

    def _placed(self, data: bytes, number: int, slot: int, size: int) -> Message:
        body = self._body(number, slot, size)
        head, start = unpack_head(data[DOORBELL.size :])
        words = data[DOORBELL.size + start :]
        if len(words) % 8:
            raise InvalidMessage(f"places of arrays take {len(words)} bytes")
        return self._codec.decode(head, body, np.frombuffer(words, "<i8").tolist())

    def _body(self, number: int, slot: int, size: int) -> Array:
        """(size,) uint8: the start of the slot, leased; a copy where this reader holds its share of slots."""
        arena = self._arena
        if arena is None or number != self._number or slot >= arena.slots or size > arena.capacity:
            raise InvalidMessage(f"{size} bytes in slot {slot} of arena {number}, which does not exist")
        if len(self._held) >= self._quota:
            body = aligned(size)
            body[:] = arena.bytes[slot, :size]
            self._release(number, slot, self._sequence)
            return body
        self._held.add((number, slot))
        release = partial(self._release, number, slot, self._sequence)
        return np.asarray(Lease(arena, slot, (size,), "|u1", release, writable=False))

    def _release(self, number: int, slot: int, stamp: int) -> None:
        """Let go of the message of this stamp (its sequence number + 1)."""
        if self._control is not None:
            self._control.released(number)[slot] = stamp
        self._held.discard((number, slot))
        self._wake()

    def _map(self, fd: int, kind: int, number: int, slot: int, size: int, value: int) -> None:
        """Map the memory that a datagram brought. Raises OSError, ValueError, OverflowError."""
        if kind == HELLO:
            self._control = Control(Memory(fd, Control.size(size), writable=True), size)
            self._quota = slot
            self._slots = size
            self._sequence = self._consumed = value
        else:
            if number >= ARENAS:
                raise ValueError(f"arena {number}, at most {ARENAS} allowed")
            self._arena = Arena(Memory(fd, self._slots * value, writable=False), self._slots, value)
            self._number = number

    def _wake(self) -> None:
        """Wake the writer if it asked for that."""
        control = self._control
        if control is None:
            return
        fence()
        if control.waiting:
            control.waiting = False
            with contextlib.suppress(OSError):  # a full socket wakes it, a closed one has nobody to wake
                self._socket.send(b"\1")
