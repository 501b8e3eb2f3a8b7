"""Previews from other hosts, over Zenoh; pictures travel only while a browser shows them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from followspot import Network
from followspot.taps.receivers import RemoteReceiver, tap_key
from followspot_page.display.feed import Arrivals
from followspot_page.taps.shown_ports import TAP, ShownPort


class RemotePreviews:
    """Hands previews of ports on other hosts to the running event loop. Use `open` and `close`.

    take: receives the port of a preview, and the packed message.
    """

    def __init__(self, receiver: RemoteReceiver, run: str) -> None:
        self._receiver = receiver
        self._run = run
        self._ports: Sequence[ShownPort] = ()
        self._watched = False

    @classmethod
    async def open(cls, network: Network, run: str, take: Callable[[str, bytes], Any]) -> RemotePreviews:
        """With a Zenoh session of its own. Raises FollowspotError if the network cannot be reached."""
        consume = Arrivals(take).consume
        return cls(await asyncio.to_thread(RemoteReceiver, network, {}, consume), run)

    def select(self, ports: Iterable[ShownPort]) -> None:
        """Subscribe to exactly the given ports that are on other hosts."""
        self._ports = [port for port in ports if port.host]
        self._subscribe()

    def watch(self, *, watched: bool) -> None:
        """Subscribe to pictures and readings while a browser shows them."""
        self._watched = watched
        self._subscribe()

    def close(self) -> None:
        """Unsubscribe, and close the session."""
        self._receiver.close()

    def _subscribe(self) -> None:
        ports = [port for port in self._ports if self._watched or not port.watched_only]
        self._receiver.select({port.name: tap_key(self._run, port.host, port.name, TAP) for port in ports})
