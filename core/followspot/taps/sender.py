"""The connection of a worker to a receiver of taps: a bounded queue and a thread that sends."""

from __future__ import annotations

import socket
import threading
from collections import deque
from pathlib import Path

from followspot.taps.framing import head_of

MAX_WAITING = 64 << 20
"""Bytes that may wait in a queue for the receiver."""
_CLOSING = 3.0
"""Seconds for the receiver to take the rest of the queue at the end."""


class TapSender:
    """Sends the messages of all taps of one worker to one receiver."""

    def __init__(self, path: Path) -> None:
        """path: socket that the receiver listens on. Raises OSError if none listens."""
        self.users = 0
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._socket.connect(str(path))
        except OSError:
            self._socket.close()
            raise
        self._waiting: deque[tuple[bytes, bytes]] = deque()
        self._bytes = 0
        self._over = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="tap", daemon=True)
        self._thread.start()

    def send(self, port: str, number: int, packed: bytes) -> None:
        """Queue a message, or drop it if the queue is full. Raises EOFError if the receiver has gone."""
        head = head_of(port, number, packed)
        with self._changed:
            if self._over:
                raise EOFError("the receiver of the tap has gone")
            if self._bytes + len(packed) <= MAX_WAITING:
                self._bytes += len(packed)
                self._waiting.append((head, packed))
                self._changed.notify()

    def close(self) -> None:
        """Send the rest of the queue and close the connection."""
        with self._changed:
            self._over = True
            self._changed.notify()
        self._thread.join(_CLOSING)
        self._socket.close()

    def _work(self) -> None:
        while record := self._next():
            try:
                for part in record:
                    self._socket.sendall(part)
            except OSError:
                with self._changed:
                    self._over = True
                    self._waiting.clear()
                return

    def _next(self) -> tuple[bytes, bytes] | None:
        """The oldest message of the queue; None at the end."""
        with self._changed:
            while not (self._waiting or self._over):
                self._changed.wait()
            if not self._waiting:
                return None
            head, packed = self._waiting.popleft()
            self._bytes -= len(packed)
            return head, packed


_senders: dict[Path, TapSender] = {}
"""The senders of this process by socket path; `_lock` guards them."""
_lock = threading.Lock()


def acquire(path: Path) -> TapSender:
    """The sender of this process to a receiver. Raises OSError if none listens."""
    with _lock:
        sender = _senders.get(path) or TapSender(path)
        _senders[path] = sender
        sender.users += 1
        return sender


def release(path: Path) -> None:
    """Close the sender when its last user releases it."""
    with _lock:
        sender = _senders[path]
        sender.users -= 1
        if sender.users:
            return
        del _senders[path]
    sender.close()
