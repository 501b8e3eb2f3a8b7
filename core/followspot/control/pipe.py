"""Carrier between a host and a worker: requests as JSON lines over a socket pair, and file descriptors.

The channel has no name and no port; only the two processes that were given its ends can speak on it.
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

MAX_LINE = 64 << 20
"""Longest message, bytes; a plan with a room of a thousand cameras is smaller."""
MAX_DESCRIPTORS = 8
"""Most file descriptors that travel with one message."""
MAX_WAITING = 1024
"""Most that wait for the messages that they came with: ends of all the rings of a worker."""


class ChannelClosed(ConnectionError):
    """The other process has ended."""


class Received(NamedTuple):
    """A request, and the descriptors that came beside it, in their order."""

    request: Request
    descriptors: Sequence[int]


class Channel:
    """One end. Sending is safe from any thread; receiving is for one."""

    def __init__(
        self, end: socket.socket, kinds: Mapping[str, type[Request]], *, takes_descriptors: bool = True
    ) -> None:
        """kinds: types of what the other process may send, by verb.

        takes_descriptors: whether it may send descriptors beside them; else they are closed unseen.
        """
        self.socket = end
        self._kinds = kinds
        self._most = MAX_DESCRIPTORS if takes_descriptors else 0
        self._lock = threading.Lock()
        self._pending = bytearray()
        self._searched = 0
        """Bytes of what is pending in which there is no end of a line."""
        self._descriptors: deque[int] = deque()

    def fileno(self) -> int:
        """Readable when something arrived or the other process has ended."""
        return self.socket.fileno()

    def send(self, request: Request, descriptors: Sequence[int] = ()) -> None:
        """Send one request; copies of the descriptors belong to the other process. Raises ChannelClosed."""
        line = json.dumps({"descriptors": len(descriptors), **to_wire(request)}).encode() + b"\n"
        try:
            with self._lock:
                sent = socket.send_fds(self.socket, [line], list(descriptors)) if descriptors else 0
                self.socket.sendall(line[sent:])
        except OSError as error:
            raise ChannelClosed(str(error)) from error

    def receive(self) -> Received:
        """The next request; waits for it. Raises ChannelClosed, ValueError."""
        while not self._has_line():
            self._pending += self._more()
        return self._cut()

    def waits(self, seconds: float) -> bool:
        """Whether there is something to `receive` within this time."""
        poll = select.poll()
        poll.register(self.socket, select.POLLIN)
        return self._has_line() or bool(poll.poll(seconds * 1e3))

    def arrived(self) -> list[Received]:
        """Call when readable: what is complete by now. Raises ChannelClosed, ValueError."""
        self._pending += self._more()
        return self.buffered()

    def buffered(self) -> list[Received]:
        """What came along with requests received before; `fileno` does not tell of it. Raises ValueError."""
        received = []
        while self._has_line():
            received.append(self._cut())
        return received

    def close(self) -> None:
        """Close this end; the other process sees it at once."""
        self.socket.close()
        while self._descriptors:
            os.close(self._descriptors.popleft())

    def shut(self) -> None:
        """Let both ends find the channel closed; safe from any thread."""
        with suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)

    def _more(self) -> bytes:
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

    def _cut(self) -> Received:
        """The first request. Raises ValueError."""
        end = self._pending.index(b"\n", self._searched)
        line = bytes(self._pending[:end])
        del self._pending[: end + 1]
        self._searched = 0
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
        """Whether a message is complete; looks only at what came since it was not."""
        found = self._pending.find(b"\n", self._searched) >= 0
        if not found:
            self._searched = len(self._pending)
        return found
