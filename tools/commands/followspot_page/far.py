"""Previews from other hosts, over Zenoh; pictures travel only while somebody looks."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from typing import Any

import zenoh

from followspot.tracking import Frame
from followspot.transport.keys import look_key
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.post import looking
from followspot.transport.zenoh.session import close_session, connected
from followspot.transport.zenoh.terms import undeclare
from followspot_page.taps import TAP, ShownPort

_WAITING = 256
"""Previews that may wait for the page; what comes then is dropped."""


class FarPreviews:
    """Hands previews of ports on other hosts to the running event loop. `open` it, `close` it.

    take: gets the port that a preview came from, and its packet.
    """

    def __init__(self, session: zenoh.Session, run: str, take: Callable[[str, bytes], Any]) -> None:
        self._session = session
        self._run = run
        self._take = take
        self._loop = asyncio.get_running_loop()
        self._waiting = 0
        self._ports: dict[str, ShownPort] = {}
        self._subscribers: dict[str, zenoh.Subscriber[None]] = {}
        self._watched = False

    @classmethod
    async def open(cls, network: Network, run: str, take: Callable[[str, bytes], Any]) -> FarPreviews:
        """With a session of its own. Raises FollowspotError."""
        return cls(await asyncio.to_thread(connected, network), run, take)

    def look(self, ports: Iterable[ShownPort]) -> None:
        """From now on at those of these ports that are on other hosts."""
        self._ports = {port.name: port for port in ports if port.host}
        undeclare(self._subscribers.values())
        self._subscribers.clear()
        self._subscribe()

    def watch(self, *, watched: bool) -> None:
        """Whether anybody looks at pictures."""
        self._watched = watched
        self._subscribe()

    def close(self) -> None:
        """Look no more."""
        close_session(self._session)

    def _subscribe(self) -> None:
        for name, port in self._ports.items():
            wanted = self._watched or port.type is not Frame
            if wanted and name not in self._subscribers:
                key = look_key(self._run, port.host, name, TAP)
                self._subscribers[name] = looking(self._session, key, self._taker(name))
            elif not wanted and name in self._subscribers:
                undeclare([self._subscribers.pop(name)])

    def _taker(self, port: str) -> Callable[[bytes], None]:
        """What a thread of Zenoh calls."""

        def take(packet: bytes) -> None:
            if self._waiting < _WAITING:
                self._waiting += 1
                self._loop.call_soon_threadsafe(self._arrived, port, packet)

        return take

    def _arrived(self, port: str, packet: bytes) -> None:
        self._waiting -= 1
        self._take(port, packet)
