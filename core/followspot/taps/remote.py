"""Packets of taps on other hosts, over Zenoh."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from followspot.transport.keys import tap_key

if TYPE_CHECKING:
    import zenoh

    from followspot.transport.zenoh.network import Network

__all__ = ["RemoteTaps", "tap_key"]


class RemoteTaps:
    """Subscriptions to the taps of a run, with a Zenoh session of their own."""

    def __init__(self, network: Network, run: str) -> None:
        """Raises FollowspotError if the network cannot be reached."""
        from followspot.transport.zenoh.session import connected

        self._run = run
        self._session = connected(network)
        self._subscribers: dict[str, zenoh.Subscriber[None]] = {}

    def subscribe(self, port: str, host: str, uses: str, take: Callable[[bytes], None]) -> None:
        """Take the packets of a port (STAGE.PORT) from now on, unless they are taken already.

        host: of the port's stage; uses: the tap; take: called with each packet in a thread of Zenoh.
        """
        from followspot.transport.zenoh.post import subscribe

        if port not in self._subscribers:
            self._subscribers[port] = subscribe(self._session, tap_key(self._run, host, port, uses), take)

    def unsubscribe(self, *ports: str) -> None:
        """Take no more packets of these ports."""
        from followspot.transport.zenoh.terms import undeclare

        undeclare([self._subscribers.pop(port) for port in ports if port in self._subscribers])

    def close(self) -> None:
        """Take no more packets, and close the session."""
        from followspot.transport.zenoh.session import close_session

        self.unsubscribe(*self._subscribers)
        close_session(self._session)
