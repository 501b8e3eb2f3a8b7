"""The datagrams that notify readers of a ring, and the writer's end of the socket to one reader.

Datagram: `NOTIFICATION` (kind, arena, slot, size, value), then for a message its packed head, then its
arrays (INLINE) or the index in the slot at which each begins, 8 bytes each (SLOT).
"""

from __future__ import annotations

import contextlib
import socket
from collections import deque
from struct import Struct

from followspot.messages import MAX_BYTES
from followspot.transport.ring.control import ARENAS, Control, fence
from followspot.transport.ring.memory import Memory
from followspot.transport.token import END

NOTIFICATION = Struct("<BBHIq")
HELLO, ARENA, INLINE, SLOT, WATERMARK = range(1, 6)
"""HELLO: slot = most leases, size = number of slots, value = first sequence number; with the control memory.
ARENA: value = capacity of a slot, bytes; with the memory of the slots. INLINE, SLOT: value = sequence number,
size = bytes of arrays. WATERMARK: value = its time, ns."""
OVER = NOTIFICATION.pack(WATERMARK, 0, 0, 0, END)
MAX_SLOTS = 1 << 16
"""Most slots of an arena: as many as a datagram can number."""
MAX_SLOT = 2 * MAX_BYTES
"""Largest slot, bytes: the arrays with their padding, rounded up to a power of two."""
_WAKES = 256
"""Most wake-ups that `drain` clears at once."""
INLINE_BYTES = 4096
"""Most bytes of arrays that travel in the datagram."""


class Link:
    """One reader as the writer sees it: a socket, shared words, and datagrams that wait for the socket."""

    def __init__(self, sock: socket.socket, control: Control, depth: int) -> None:
        """depth: most messages that the reader gives credit for."""
        sock.setblocking(False)
        self.socket = sock
        self.control = control
        self.alive = True
        self.ended = False
        self.expelled = False
        """Whether the writer cut it off, because it did what no reader does."""
        self._most = 2 * (depth + ARENAS)
        self._sent = 0
        self._pending: deque[tuple[bytes, Memory | None]] = deque()

    def send(self, datagram: bytes, memory: Memory | None = None) -> None:
        """Send the datagram, with the memory's descriptor, in order: now, or when the socket takes it."""
        if self._pending:
            if datagram[0] == WATERMARK == self._pending[-1][0][0]:
                self._pending.pop()
            self._pending.append((datagram, memory))
            if len(self._pending) > self._most:  # it gives credit for messages that it cannot have read
                self.expel()
        elif not self._try_send(datagram, memory):
            self._pending.append((datagram, memory))
            self.flush()

    def flush(self) -> bool:
        """Send what waits. True when nothing waits; else ask the reader for a wake-up."""
        if self._pending:
            self.ask()
        while self.alive and self._pending and self._try_send(*self._pending[0]):
            self._pending.popleft()
        return not (self.alive and self._pending)

    def ask(self) -> None:
        """Ask the reader for a wake-up when it next gives credit, releases a slot or empties the socket."""
        self.control.waiting = True
        fence()

    def expel(self) -> None:
        """Cut the reader off; `drain` will find it gone."""
        self.expelled = True
        with contextlib.suppress(OSError):  # it died meanwhile
            self.socket.shutdown(socket.SHUT_RDWR)

    def drain(self) -> None:
        """Clear wake-ups, at most so many; an end of file is the reader's death."""
        try:
            for _ in range(_WAKES):
                if not self.socket.recv(1):
                    break
            else:
                return
        except BlockingIOError:
            return
        except OSError:
            pass
        self.alive = False

    def _try_send(self, datagram: bytes, memory: Memory | None) -> bool:
        try:
            if memory is None:
                self.socket.send(datagram)
            else:
                socket.send_fds(self.socket, [datagram], [memory.fd])
        except BlockingIOError:
            return False
        except OSError:
            return True  # the reader died; until `drain` notices, this counts as on its way
        self.ended = datagram == OVER
        self._sent += 1
        self.control.sent = self._sent
        return True
