"""Previews from other hosts, over Zenoh; pictures travel only while a browser shows them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from followspot import Network
from followspot.taps.remote import RemoteTaps
from followspot.tracking import Frame
from followspot_page.feed import Arrivals
from followspot_page.taps import TAP, ShownPort


class RemotePreviews:
    """Hands previews of ports on other hosts to the running event loop. Use `open` and `close`.

    take: receives the port of a preview, and its packet.
    """

    def __init__(self, remote: RemoteTaps, take: Callable[[str, bytes], Any]) -> None:
        self._remote = remote
        self._arrivals = Arrivals(take)
        self._ports: dict[str, ShownPort] = {}
        self._watched = False

    @classmethod
    async def open(cls, network: Network, run: str, take: Callable[[str, bytes], Any]) -> RemotePreviews:
        """With a Zenoh session of its own. Raises FollowspotError if the network cannot be reached."""
        return cls(await asyncio.to_thread(RemoteTaps, network, run), take)

    def look(self, ports: Iterable[ShownPort]) -> None:
        """Subscribe to those of these ports that are on other hosts, and to no others."""
        self._remote.unsubscribe(*self._ports)
        self._ports = {port.name: port for port in ports if port.host}
        self._subscribe()

    def watch(self, *, watched: bool) -> None:
        """Subscribe to pictures while a browser shows them."""
        self._watched = watched
        self._subscribe()

    def close(self) -> None:
        """Unsubscribe, and close the session."""
        self._remote.close()

    def _subscribe(self) -> None:
        for name, port in self._ports.items():
            if self._watched or port.type is not Frame:
                self._remote.subscribe(name, port.host, TAP, partial(self._arrivals.put, name))
            else:
                self._remote.unsubscribe(name)
