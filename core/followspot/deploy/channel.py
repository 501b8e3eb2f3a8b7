"""The control channel between launcher and worker: JSON lines over a socket pair.

It has no name and no port; only the two processes that were given its ends can speak on it.
"""

from __future__ import annotations

import json
import socket
import threading
from typing import Any

MAX_LINE = 64 << 20
"""Longest message, bytes; a plan with a room of a thousand cameras is smaller."""


class ChannelClosed(ConnectionError):
    """The other process has ended."""


class Channel:
    """One end. Sending is safe from any thread; receiving is for one."""

    def __init__(self, end: socket.socket) -> None:
        self.socket = end
        self._lock = threading.Lock()
        self._pending = b""

    def fileno(self) -> int:
        """Readable when something arrived or the other process has ended."""
        return self.socket.fileno()

    def send(self, kind: str, **data: Any) -> None:
        """Send one message. Raises ChannelClosed."""
        line = json.dumps({"kind": kind, **data}).encode() + b"\n"
        try:
            with self._lock:
                self.socket.sendall(line)
        except OSError as error:
            raise ChannelClosed(str(error)) from error

    def receive(self) -> dict[str, Any]:
        """The next message; waits for it. Raises ChannelClosed, ValueError."""
        while b"\n" not in self._pending:
            self._pending += self._more()
        return self._cut()

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

    def _more(self) -> bytes:
        try:
            data = self.socket.recv(1 << 16)
        except OSError as error:
            raise ChannelClosed(str(error)) from error
        if not data:
            raise ChannelClosed("the other process has ended")
        if len(self._pending) + len(data) > MAX_LINE:
            raise ValueError(f"a control message is longer than {MAX_LINE} bytes")
        return data

    def _cut(self) -> dict[str, Any]:
        line, _, self._pending = self._pending.partition(b"\n")
        message = json.loads(line)
        if not isinstance(message, dict) or "kind" not in message:
            raise ValueError("a control message is not an object with a kind")
        return message
