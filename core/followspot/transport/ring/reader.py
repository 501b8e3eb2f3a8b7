"""The reading end of the ring: messages whose arrays are views of the writer's memory."""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Callable, Sequence

from followspot.messages import Message
from followspot.transport.ring.control import CONSUMED, SENT, WAITING, fence
from followspot.transport.ring.decoder import Decoder
from followspot.transport.ring.notification import CARRIES, INLINE, WATERMARK
from followspot.transport.ring.reader_memory import unmapped
from followspot.transport.token import END, Token, Watermark

_ANCILLARY, _FLAGS = socket.CMSG_LEN(4), socket.MSG_CMSG_CLOEXEC
"""A datagram may bring one file descriptor."""
_BATCH = 256
"""Most datagrams that one poll takes, so that a flood of watermarks does not hold up the worker."""
_MOST_QUEUED = 4096
"""More datagrams than a socket holds at once."""


def _nothing() -> None:
    """Do nothing: no worker waits for tokens."""


class RingReader:
    """`PortReader` on the writer's host.

    The arrays of a message are read-only views; the slot is released when the last of them dies. A stage may
    keep any number of messages: beyond its share of the slots, it gets copies. If several edges lead from one
    port to this process, what comes for the first, their carrier, is handed to the readers of the others.
    """

    def __init__(
        self,
        sock: socket.socket,
        kind: type[Message],
        reader_beside: Callable[[int], RingReader | None] = lambda edge: None,
    ) -> None:
        """sock: the other end of the writer's socket; kind: type of the messages.

        reader_beside: finds the reader here of another edge from the same port.
        """
        sock.setblocking(False)
        self._socket = sock
        self._decoder = Decoder(sock, kind)
        self._memory = self._decoder.memory
        self._buffers = [self._decoder.buffer]
        self._received = 0
        self._consumed = 0
        self._ended = False
        self._closed = False
        self._reader_beside = reader_beside
        self._carrier: RingReader | None = None
        self._carried: list[RingReader] = []
        self._arrived: list[Token] = []
        """Tokens for the next poll."""
        self.notify: Callable[[], object] = _nothing
        """Called when another reader has handed tokens to this one: poll it."""

    @property
    def rejected(self) -> int:
        """How many datagrams came that no writer sends."""
        return self._decoder.refused

    @property
    def lost(self) -> bool:
        """Whether the writer is gone without having ended the stream."""
        return self._closed and not self._ended

    @property
    def broken(self) -> bool:
        """Whether the writer is gone: its replacement has another socket."""
        return self._closed

    @property
    def caught_up(self) -> bool:
        """Whether `poll` has taken everything that the writer has sent so far."""
        control = self._memory.control
        return self._closed or (control is not None and self._received >= control.words[SENT])

    def report_at_once(self, at_once: bool) -> None:
        """Do nothing: the writer needs no report, because `caught_up` reads shared memory."""

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
        control = self._memory.control
        if control is None or not (self._carrier and self._arrived):
            self._read(_BATCH)
            control = self._memory.control
        if control is not None and control.words[WAITING]:
            self._memory.wake(control)
        if self._carried:
            self._notify_carried()
        tokens, self._arrived = self._arrived, []
        if tokens and isinstance(tokens[-1], Watermark):
            self._ended = tokens[-1].time == END
        return tokens

    def hand_over(self) -> None:
        """Before it is closed: give arrived messages to the readers for which this one receives."""
        self._read(_MOST_QUEUED)
        self._notify_carried()

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that left the queue."""
        control = self._memory.control
        if control is not None:
            self._consumed += count
            control.words[CONSUMED] = self._decoder.first + self._consumed
            fence()
            if control.words[WAITING]:
                self._memory.wake(control)

    def close(self) -> None:
        """Close the socket; messages that a stage still holds stay valid, and release their slots later."""
        self._part()
        self.notify = _nothing
        self._socket.close()

    def _read(self, most: int) -> None:
        """Take at most `most` datagrams from the socket.

        A poll stops at the last that the writer says to have sent, which saves a system call. Raises
        FollowspotError if memory that came cannot be mapped.
        """
        for _ in range(most):
            try:
                size, extra, flags, _ = self._socket.recvmsg_into(self._buffers, _ANCILLARY, _FLAGS)
            except BlockingIOError:
                break
            except ConnectionResetError:
                continue  # the writer left wake-ups unread; its datagrams are still there
            except OSError:
                size = 0
            if not size:
                self._go_on_alone()
                self._closed = True
                break
            if flags & socket.MSG_CTRUNC and not extra:  # the system had no number for the descriptor
                raise unmapped(OSError(errno.EMFILE, os.strerror(errno.EMFILE)))
            self._received += 1
            kind = self._buffers[0][0]
            if kind > WATERMARK and self._shares(size, extra):
                continue
            if self._carrier is not None and INLINE <= kind <= WATERMARK:
                self._go_on_alone()
            tokens = self._decoder.tokens(size, extra)
            self._arrived += tokens
            for reader in self._carried:
                reader._arrived += tokens
            control = self._memory.control
            if most == _BATCH and control is not None and self._received >= control.words[SENT]:
                break

    def _shares(self, end: int, extra: Sequence[tuple[int, int, bytes]]) -> bool:
        """Whether the datagram in the buffer made two readers share; end, extra: see `Decoder.tokens`."""
        shares = self._decoder.shares(end, extra)
        return shares is not None and self._share(*shares)

    def _share(self, kind: int, edge: int) -> bool:
        """Share datagrams with the reader of another edge from now on; False if no writer asks for that."""
        other = self._reader_beside(edge)
        if other is None or other is self:
            return False
        if kind == CARRIES:
            return other._join(self)
        if self._carrier is None:  # the carrier has not read the datagram that says so yet
            other._read(_MOST_QUEUED)
            other.notify()
        return self._carrier is other

    def _join(self, carrier: RingReader) -> bool:
        """Get tokens from the carrier from now on; False if this reader cannot."""
        if self._carrier or self._carried or self._closed:
            return False
        self._carrier = carrier
        carrier._carried.append(self)
        return True

    def _notify_carried(self) -> None:
        for reader in tuple(self._carried):
            if reader._arrived:
                reader.notify()

    def _go_on_alone(self) -> None:
        """Take what the carrier still has for this reader; what follows comes by its own socket."""
        carrier = self._carrier
        if carrier is not None:
            carrier._read(_MOST_QUEUED)
            self._decoder.sequence = carrier._decoder.sequence
            self._part()
            carrier.notify()
            carrier._notify_carried()

    def _part(self) -> None:
        """Get no more tokens from the carrier."""
        if self._carrier is not None:
            self._carrier._carried.remove(self)
            self._carrier = None
