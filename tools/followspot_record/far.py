"""What recording taps on other hosts send, over Zenoh, in a queue with a limit."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from functools import partial

from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.post import looking
from followspot.transport.zenoh.session import close_session, connected
from followspot_recording.record_sender import MAX_WAITING, framed_record

Take = Callable[[str, int, bytes], None]
"""Gets port, number and packed message."""


class FarTaps:
    """Listens to the taps of these ports, by key, and hands over what they send in a thread of its own."""

    def __init__(self, network: Network, keys: dict[str, str], take: Take) -> None:
        """keys: of Zenoh, by port. Raises FollowspotError where there is no way to the other hosts."""
        self._take = take
        self._waiting: deque[tuple[str, bytes]] = deque()
        self._bytes = 0
        self._over = False
        self._news = threading.Condition()
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()
        self._session = connected(network)
        for port, key in keys.items():
            looking(self._session, key, partial(self._arrived, port))

    def close(self) -> None:
        """Hand over what waits, and listen no more."""
        close_session(self._session)
        with self._news:
            self._over = True
            self._news.notify()
        self._thread.join()

    def _arrived(self, port: str, packet: bytes) -> None:
        """In a thread of Zenoh: what finds no room is left out, which its number tells."""
        with self._news:
            if self._bytes + len(packet) <= MAX_WAITING:
                self._bytes += len(packet)
                self._waiting.append((port, packet))
                self._news.notify()

    def _work(self) -> None:
        while True:
            with self._news:
                while not (self._waiting or self._over):
                    self._news.wait()
                if not self._waiting:
                    return
                port, packet = self._waiting.popleft()
                self._bytes -= len(packet)
            record = framed_record(packet)
            if record is not None and record[0] == port:  # a host speaks for its own ports only
                self._take(*record)
