"""The writer's end of the socket to one reader of a ring."""

from __future__ import annotations

import contextlib
import logging
import socket
from collections import deque

from followspot.operating_system.descriptors import crowded
from followspot.transport.ring.control import ARENAS, SENT, WAITING, Control, fence
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import INLINE, OVER, SLOT, WATERMARK

_TOKENS = (INLINE, SLOT, WATERMARK)
_WAKES = 256
"""Most wake-ups that `drain` clears at once."""
_CROWDED = (
    "an edge waits: too many descriptors are on their way between the processes of this user; "
    "raise the limit of open files, for example ulimit -n 4096, or take fewer workers: --placement"
)


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
        """Whether the writer cut the reader off, because the reader broke the protocol."""
        self.carrier: Link | None = None
        """The link to another reader in the same process, whose datagrams are for this reader, too."""
        self.carried: list[Link] = []
        """The links to other readers in the same process that share the datagrams of this one."""
        self._most = 2 * (depth + ARENAS)
        self._sent = 0
        self._pending: deque[tuple[bytes, Memory | None]] = deque()
        self._told_crowded = False

    def send(self, datagram: bytes, memory: Memory | None = None) -> None:
        """Send the datagram, with the memory's descriptor, in order: now, or when the socket takes it."""
        if self._pending:
            if datagram[0] == WATERMARK == self._pending[-1][0][0]:
                self._pending.pop()
            self._pending.append((datagram, memory))
            if (
                len(self._pending) > self._most
            ):  # the reader gives credit for messages that it cannot have read
                self.expel()
        elif not self._try_send(datagram, memory):
            self._pending.append((datagram, memory))
            self.flush()

    def flush(self) -> bool:
        """Send the waiting messages. True when none waits; else ask the reader for a wake-up."""
        if self._pending:
            self.ask()
        while self.alive and self._pending and self._try_send(*self._pending[0]):
            self._pending.popleft()
        return not (self.alive and self._pending)

    def ask(self) -> None:
        """Ask the reader for a wake-up when it next gives credit, releases a slot or empties the socket."""
        self.control.words[WAITING] = 1
        fence()

    def carry(self, other: Link) -> None:
        """Send for another reader in the same process, too, from the next datagram on."""
        other.carrier = self
        self.carried.append(other)

    def leave(self) -> list[Link]:
        """Send no more; returns the readers that it carried, which get datagrams of their own.

        What waits for this socket goes to theirs.
        """
        self.alive, self.ended = False, True
        left = self.part()
        for other in left:
            for datagram, _ in self._pending:
                if datagram[0] in _TOKENS:
                    other.send(datagram)
        return left

    def part(self) -> list[Link]:
        """Stop sharing datagrams with other readers; returns the readers that this link carried."""
        if self.carrier is not None:
            self.carrier.carried.remove(self)
            self.carrier = None
        left, self.carried = self.carried, []
        for other in left:
            other.carrier = None
        return left

    def expel(self) -> None:
        """Cut the reader off, with those that it carries for; `drain` will find them gone."""
        self.expelled = True
        for link in (self, *self.carried):
            with contextlib.suppress(OSError):  # it died meanwhile
                link.socket.shutdown(socket.SHUT_RDWR)

    def gone(self) -> bool:
        """Clear wake-ups, at most `_WAKES`; True at the end of file: the reader died."""
        try:
            for _ in range(_WAKES):
                if not self.socket.recv(1):
                    return True
        except BlockingIOError:
            return False
        except OSError:
            return True
        return False

    def _try_send(self, datagram: bytes, memory: Memory | None) -> bool:
        """Send a datagram now; False if the socket, or the kernel, takes none now."""
        try:
            if memory is None:
                self.socket.send(datagram)
            else:
                socket.send_fds(self.socket, [datagram], [memory.fd])
        except BlockingIOError:
            return False
        except OSError as error:
            if crowded(error):
                self._tell_crowded()
                return False
            return True  # the reader died; until `drain` notices, this counts as on its way
        self.ended = datagram == OVER
        for other in self.carried:
            other.ended = self.ended
        self._sent += 1
        self.control.words[SENT] = self._sent
        return True

    def _tell_crowded(self) -> None:
        """Log once that the memory of this edge waits for the descriptors of others to arrive."""
        if not self._told_crowded:
            self._told_crowded = True
            logging.getLogger(__name__).warning(_CROWDED)


def socket_pair() -> tuple[socket.socket, socket.socket]:
    """Sending and receiving end of one ring edge; they have no name, so a kill leaves nothing behind."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
