"""The way from a worker to a recorder outside: a queue with a limit, and a thread that sends."""

from __future__ import annotations

import socket
import threading
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from struct import Struct

from followspot.wire import MAX_PACKED

HEAD = Struct("<IQH")
"""Before each message: its size, its number at its port, and how long the port's name is, which follows."""
MAX_WAITING = 64 << 20
"""Bytes of a worker that may wait for the recorder."""

_PATIENCE = 3.0
"""Seconds that the recorder may take for what waits at the end."""


class RecordSender:
    """Sends what the recording taps of one worker have."""

    def __init__(self, path: Path) -> None:
        """Raises OSError where no recorder listens."""
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
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._carry, name="recording", daemon=True)
        self._thread.start()

    def send(self, port: str, number: int, packed: bytes) -> None:
        """Take a message along, or leave it where too much waits. Raises EOFError when nobody records."""
        head = head_of(port, number, packed)
        with self._news:
            if self._over:
                raise EOFError("the recorder is gone")
            if self._bytes + len(packed) <= MAX_WAITING:
                self._bytes += len(packed)
                self._waiting.append((head, packed))
                self._news.notify()

    def close(self) -> None:
        """Send what waits, and no more."""
        with self._news:
            self._over = True
            self._news.notify()
        self._thread.join(_PATIENCE)
        self._socket.close()

    def _carry(self) -> None:
        while record := self._next():
            try:
                for part in record:
                    self._socket.sendall(part)
            except OSError:
                with self._news:
                    self._over = True
                    self._waiting.clear()
                return

    def _next(self) -> tuple[bytes, bytes] | None:
        """The oldest that waits; None at the end."""
        with self._news:
            while not (self._waiting or self._over):
                self._news.wait()
            if not self._waiting:
                return None
            head, packed = self._waiting.popleft()
            self._bytes -= len(packed)
            return head, packed


def head_of(port: str, number: int, packed: bytes) -> bytes:
    """What stands before a packed message."""
    name = port.encode()
    return HEAD.pack(len(packed), number, len(name)) + name


def framed_record(packet: bytes) -> tuple[str, int, bytes] | None:
    """Port, number and packed message of a packet that holds exactly one; None if it does not."""
    if len(packet) < HEAD.size:
        return None
    size, number, name = HEAD.unpack_from(packet)
    start = HEAD.size + name
    if len(packet) != start + size:
        return None
    return packet[HEAD.size : start].decode(errors="replace"), number, packet[start:]


def framed_records(sender: socket.socket) -> Iterator[tuple[str, int, bytes]]:
    """Port, number and packed message of all that a sender brings, until it leaves. Raises ValueError."""
    while head := _exactly(sender, HEAD.size):
        size, number, name = HEAD.unpack(head)
        if size > MAX_PACKED:
            raise ValueError(f"a message of {size} bytes")
        port = _exactly(sender, name).decode()
        packed = _exactly(sender, size)
        if len(packed) < size:
            return
        yield port, number, packed


def _exactly(sender: socket.socket, size: int) -> bytes:
    """So many bytes; fewer where the sender is gone."""
    data = bytearray(size)
    view, filled = memoryview(data), 0
    while filled < size:
        try:
            more = sender.recv_into(view[filled:])
        except OSError:
            more = 0
        if not more:
            return bytes(data[:filled]) if filled == size else b""
        filled += more
    return bytes(data)


_senders: dict[Path, RecordSender] = {}
"""The senders of this process by socket path; `_lock` guards them."""
_lock = threading.Lock()


def acquire(path: Path) -> RecordSender:
    """The sender of this process to a recorder. Raises OSError."""
    with _lock:
        sender = _senders.get(path) or RecordSender(path)
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
