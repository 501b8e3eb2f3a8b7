"""The control channel between an agent and a worker: JSON lines over a socket pair, and file descriptors.

It has no name and no port; only the two processes that were given its ends can speak on it.
"""

from __future__ import annotations

import json
import os
import select
import socket
import threading
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

MAX_LINE = 64 << 20
"""Longest message, bytes; a plan with a room of a thousand cameras is smaller."""
MAX_DESCRIPTORS = 8
"""Most file descriptors that travel with one message."""


class ChannelClosed(ConnectionError):
    """The other process has ended."""


class Channel:
    """One end. Sending is safe from any thread; receiving is for one."""

    def __init__(self, end: socket.socket) -> None:
        self.socket = end
        self._lock = threading.Lock()
        self._pending = b""
        self._descriptors: deque[int] = deque()

    def fileno(self) -> int:
        """Readable when something arrived or the other process has ended."""
        return self.socket.fileno()

    def send(self, kind: str, descriptors: Sequence[int] = (), **data: Any) -> None:
        """Send one message; copies of the descriptors belong to the other process. Raises ChannelClosed."""
        line = json.dumps({"kind": kind, "descriptors": len(descriptors), **data}).encode() + b"\n"
        try:
            with self._lock:
                sent = socket.send_fds(self.socket, [line], list(descriptors)) if descriptors else 0
                self.socket.sendall(line[sent:])
        except OSError as error:
            raise ChannelClosed(str(error)) from error

    def receive(self) -> dict[str, Any]:
        """The next message; waits for it. Raises ChannelClosed, ValueError."""
        while b"\n" not in self._pending:
            self._pending += self._more()
        return self._cut()

    def waits(self, seconds: float) -> bool:
        """Whether there is something to `receive` within this time."""
        poll = select.poll()
        poll.register(self.socket, select.POLLIN)
        return b"\n" in self._pending or bool(poll.poll(seconds * 1e3))

    def arrived(self) -> list[dict[str, Any]]:
        """Call when readable: what is complete by now. Raises ChannelClosed, ValueError."""
        self._pending += self._more()
        return self.buffered()

    def buffered(self) -> list[dict[str, Any]]:
        """What came along with messages received before; `fileno` does not tell of it. Raises ValueError."""
        messages = []
        while b"\n" in self._pending:
            messages.append(self._cut())
        return messages

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
                self.socket, 1 << 16, MAX_DESCRIPTORS, socket.MSG_CMSG_CLOEXEC
            )
        except OSError as error:
            raise ChannelClosed(str(error)) from error
        self._descriptors.extend(descriptors)
        if not data:
            raise ChannelClosed("the other process has ended")
        if len(self._pending) + len(data) > MAX_LINE:
            raise ValueError(f"a control message is longer than {MAX_LINE} bytes")
        return data

    def _cut(self) -> dict[str, Any]:
        """The first message; its `descriptors` are those that came with it, in their order."""
        line, _, self._pending = self._pending.partition(b"\n")
        message = json.loads(line)
        if not isinstance(message, dict) or "kind" not in message:
            raise ValueError("a control message is not an object with a kind")
        count = min(int(message.get("descriptors", 0)), len(self._descriptors))
        message["descriptors"] = [self._descriptors.popleft() for _ in range(count)]
        return message
