"""The carrier between a host and a worker: JSON lines and file descriptors over a socket pair.

The pair has no name and no port, so only the two processes that have its ends can use it.
"""

from __future__ import annotations

import json
import os
import select
import socket
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

from followspot.control.dispatch import Request, from_wire, to_wire
from followspot.operating_system.descriptors import crowded, send_descriptors

MAX_LINE = 64 << 20
"""Longest message, bytes; the plan of a room with a thousand cameras is shorter."""
MAX_DESCRIPTORS = 8
"""Most file descriptors that travel with one message."""
MAX_WAITING = 1024
"""Most descriptors that wait for their messages: enough for all rings of a worker."""


class ChannelClosed(ConnectionError):
    """The other process has ended."""


class Received(NamedTuple):
    """A request, and the descriptors that came with it, in their order."""

    request: Request
    descriptors: Sequence[int]


class Channel:
    """One end of the pair. Any thread may send; only one thread may receive."""

    def __init__(
        self, end: socket.socket, kinds: Mapping[str, type[Request]], *, takes_descriptors: bool = True
    ) -> None:
        """kinds: types of requests that the other process may send, by verb.

        takes_descriptors: whether it may send descriptors; if not, the kernel discards them.
        """
        self.socket = end
        self._kinds = kinds
        self._most = MAX_DESCRIPTORS if takes_descriptors else 0
        self._lock = threading.Lock()
        self._pending = bytearray()
        self._newline_free = 0
        """Number of pending bytes that are known to contain no newline."""
        self._descriptors: deque[int] = deque()

    def fileno(self) -> int:
        """Readable when something arrived or the other process has ended."""
        return self.socket.fileno()

    def send(self, request: Request, descriptors: Sequence[int] = ()) -> None:
        """Send one request; the other process gets copies of the descriptors.

        Raises ChannelClosed, OSError if too many descriptors of this user stay on their way.
        """
        line = json.dumps({"descriptors": len(descriptors), **to_wire(request)}).encode() + b"\n"
        try:
            with self._lock:
                sent = send_descriptors(self.socket, line, descriptors) if descriptors else 0
                self.socket.sendall(line[sent:])
        except OSError as error:
            if crowded(error):
                raise
            raise ChannelClosed(str(error)) from error

    def send_if_open(self, request: Request, descriptors: Sequence[int] = ()) -> None:
        """Send one request unless the other process has ended, which the next `receive` notices.

        Raises OSError as `send` does.
        """
        with suppress(ChannelClosed):
            self.send(request, descriptors)

    def receive(self) -> Received:
        """Wait for the next request. Raises ChannelClosed, ValueError if it is invalid."""
        while not self._has_line():
            self._pending += self._received_bytes()
        return self._next_request()

    def waits(self, seconds: float) -> bool:
        """True if there is something to `receive` within this time, s."""
        poll = select.poll()
        poll.register(self.socket, select.POLLIN)
        return self._has_line() or bool(poll.poll(seconds * 1e3))

    def arrived(self) -> list[Received]:
        """The requests that are complete; call this when the channel is readable.

        Raises ChannelClosed, ValueError if a request is invalid.
        """
        self._pending += self._received_bytes()
        return self.buffered()

    def buffered(self) -> list[Received]:
        """Complete requests that were read with an earlier one, for which `fileno` is not readable.

        Raises ValueError if one is invalid.
        """
        received = []
        while self._has_line():
            received.append(self._next_request())
        return received

    def close(self) -> None:
        """Close this end and the waiting descriptors; the other process notices at once."""
        self.socket.close()
        while self._descriptors:
            os.close(self._descriptors.popleft())

    def shut(self) -> None:
        """Shut the channel down for both ends. Safe from any thread."""
        with suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)

    def _received_bytes(self) -> bytes:
        """Read what has arrived. Raises ChannelClosed, ValueError if the other process sends too much."""
        try:
            data, descriptors, _, _ = socket.recv_fds(
                self.socket, 1 << 16, self._most, socket.MSG_CMSG_CLOEXEC
            )
        except OSError as error:
            raise ChannelClosed(str(error)) from error
        self._descriptors.extend(descriptors)
        if not data:
            raise ChannelClosed("the other process has ended")
        if len(self._descriptors) > MAX_WAITING:
            raise ValueError(f"more than {MAX_WAITING} descriptors without a message")
        if len(self._pending) + len(data) > MAX_LINE:
            raise ValueError(f"a control message is longer than {MAX_LINE} bytes")
        return data

    def _next_request(self) -> Received:
        """Remove and return the first pending request. Raises ValueError."""
        end = self._pending.index(b"\n", self._newline_free)
        line = bytes(self._pending[:end])
        del self._pending[: end + 1]
        self._newline_free = 0
        try:
            message = json.loads(line)
        except RecursionError:
            raise ValueError("a control message is nested too deeply") from None
        if not isinstance(message, dict):
            raise ValueError("a control message is not an object")
        count = message.pop("descriptors", 0)
        if type(count) is not int or not 0 <= count <= len(self._descriptors):
            raise ValueError(f"a control message without its {str(count)[:80]} descriptors")
        descriptors = [self._descriptors.popleft() for _ in range(count)]
        return Received(from_wire(self._kinds, message), descriptors)

    def _has_line(self) -> bool:
        """True if a message is complete; searches only the bytes that are new."""
        found = self._pending.find(b"\n", self._newline_free) >= 0
        if not found:
            self._newline_free = len(self._pending)
        return found
