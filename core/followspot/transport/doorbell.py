"""The datagrams of a ring, and the writer's end of the socket that carries them to one reader.

Datagram: `DOORBELL` (kind, arena, slot, size, value), then for a message its packed head, then its
arrays (INLINE) or where in the slot each begins, 8 bytes each (SLOT).
"""

from __future__ import annotations

import socket
from collections import deque
from struct import Struct

from followspot.transport.control import Control, fence
from followspot.transport.memory import Memory
from followspot.transport.token import END

DOORBELL = Struct("<BBHIq")
HELLO, ARENA, INLINE, SLOT, SETTLED = range(1, 6)
"""HELLO: slot = most leases, size = number of slots, value = first sequence number; with the control memory.
ARENA: value = capacity of a slot, bytes; with the memory of the slots. INLINE, SLOT: value = sequence number,
size = bytes of arrays. SETTLED: value = bound, ns."""
OVER = DOORBELL.pack(SETTLED, 0, 0, 0, END)
INLINE_BYTES = 4096
"""Messages whose arrays take no more than this travel in the datagram."""


class Link:
    """One reader as the writer sees it: a socket, shared words, and datagrams that wait for room."""

    def __init__(self, sock: socket.socket, control: Control) -> None:
        sock.setblocking(False)
        self.socket = sock
        self.control = control
        self.alive = True
        self.ended = False
        self._posted = 0
        self._pending: deque[tuple[bytes, Memory | None]] = deque()

    def post(self, datagram: bytes, memory: Memory | None = None) -> None:
        """Send the datagram, with the memory's descriptor, in order; now, or when there is room."""
        if self._pending:
            if datagram[0] == SETTLED == self._pending[-1][0][0]:
                self._pending.pop()
            self._pending.append((datagram, memory))
        elif not self._sent(datagram, memory):
            self._pending.append((datagram, memory))
            self.flush()

    def flush(self) -> bool:
        """Send what waits. True when nothing waits; else the reader is asked to wake the writer."""
        if self._pending:
            self.ask()
        while self.alive and self._pending and self._sent(*self._pending[0]):
            self._pending.popleft()
        return not (self.alive and self._pending)

    def ask(self) -> None:
        """Ask the reader for a wake-up when it next gives credit, releases a slot or makes room."""
        self.control.waiting = True
        fence()

    def drain(self) -> None:
        """Swallow wake-ups; an end of file is the reader's death."""
        try:
            while self.socket.recv(1):
                pass
        except BlockingIOError:
            return
        except OSError:
            pass
        self.alive = False

    def _sent(self, datagram: bytes, memory: Memory | None) -> bool:
        try:
            if memory is None:
                self.socket.send(datagram)
            else:
                socket.send_fds(self.socket, [datagram], [memory.fd])
        except BlockingIOError:
            return False
        except OSError:
            return True  # the reader died; `drain` will find out, and until then this counts as under way
        self.ended = datagram == OVER
        self._posted += 1
        self.control.posted = self._posted
        return True
