"""The receiving ends of taps: a socket for this host, Zenoh for others."""

from __future__ import annotations

import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.taps.framing import Record, framed_record, framed_records
from followspot.taps.sender import MAX_WAITING
from followspot.transport.keys import tap_key
from followspot.transport.zenoh.network import Network

if TYPE_CHECKING:
    import zenoh

__all__ = ["Consume", "Gaps", "LocalReceiver", "RemoteReceiver", "tap_key"]
_BACKLOG = 256

Consume = Callable[[Iterator[Record]], None]
"""Consumes the records of one sender in a thread of its own; ValueError comes from a malformed stream."""


class LocalReceiver:
    """Listens for taps of this host; each worker has a connection of its own."""

    def __init__(self, path: Path, consume: Consume) -> None:
        """path: of the socket, created here. Raises OSError."""
        self._consume = consume
        self._senders: list[tuple[threading.Thread, socket.socket]] = []
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.bind(str(path))
        self._socket.listen(_BACKLOG)
        self._thread = threading.Thread(target=self._accept, name="taps", daemon=True)
        self._thread.start()

    def close(self, timeout: float = 0.0) -> None:
        """Accept no more, and disconnect the senders that have not left within `timeout`, s."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()
        deadline = time.monotonic() + timeout
        for thread, _ in self._senders:
            thread.join(max(0.0, deadline - time.monotonic()))
        for _, sender in self._senders:
            with suppress(OSError):
                sender.shutdown(socket.SHUT_RDWR)

    def _accept(self) -> None:
        while True:
            try:
                sender, _ = self._socket.accept()
            except OSError:
                return
            thread = threading.Thread(target=self._read, args=(sender,), name="tap", daemon=True)
            self._senders.append((thread, sender))
            thread.start()

    def _read(self, sender: socket.socket) -> None:
        with sender:
            self._consume(framed_records(sender))


class RemoteReceiver:
    """Subscribes to taps of other hosts, with a session of its own; one thread receives from all."""

    def __init__(self, network: Network, keys: Mapping[str, str], consume: Consume) -> None:
        """keys: as in `select`. Raises FollowspotError if the network cannot be reached."""
        from followspot.transport.zenoh.session import connected

        self._waiting: deque[tuple[str, bytes]] = deque()
        self._bytes = 0
        self._over = False
        self._changed = threading.Condition()
        self._session = connected(network)
        self._thread = threading.Thread(target=consume, args=(self._records(),), name="taps", daemon=True)
        self._thread.start()
        self._subscribers: dict[tuple[str, str], zenoh.Subscriber[None]] = {}
        self.select(keys)

    def select(self, keys: Mapping[str, str]) -> None:
        """Receive from these ports alone; keys: of their taps, see `tap_key`, by port."""
        from followspot.transport.zenoh.post import subscribe
        from followspot.transport.zenoh.terms import undeclare

        wanted = keys.items()
        undeclare([self._subscribers.pop(known) for known in self._subscribers.keys() - wanted])
        for port, key in wanted - self._subscribers.keys():
            taker = partial(self._arrived, port)
            self._subscribers[port, key] = subscribe(self._session, key, taker)

    def close(self) -> None:
        """Hear the rest of the queue, and unsubscribe."""
        from followspot.transport.zenoh.session import close_session

        close_session(self._session)
        with self._changed:
            self._over = True
            self._changed.notify()
        self._thread.join()

    def _arrived(self, port: str, packet: bytes) -> None:
        """Queue a packet, or drop it if the queue is full; runs in a thread of Zenoh."""
        with self._changed:
            if self._bytes + len(packet) <= MAX_WAITING:
                self._bytes += len(packet)
                self._waiting.append((port, packet))
                self._changed.notify()

    def _records(self) -> Iterator[Record]:
        """Records from the queue until `close`; malformed ones are left out."""
        while True:
            with self._changed:
                while not (self._waiting or self._over):
                    self._changed.wait()
                if not self._waiting:
                    return
                port, packet = self._waiting.popleft()
                self._bytes -= len(packet)
            record = framed_record(packet)
            if record is not None and record[0] == port:  # a host may send for its own ports only
                yield record


class Gaps:
    """Counts the messages that are missing between received ones."""

    def __init__(self) -> None:
        self._expected: dict[str, int] = {}

    def before(self, port: str, number: int) -> int:
        """How many messages of the port are missing before this one; 0 if its worker was started anew."""
        missing = max(0, number - self._expected.get(port, number))
        self._expected[port] = number + 1
        return missing
