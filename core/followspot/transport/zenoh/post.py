"""Packets of taps over Zenoh to observers: of the lowest priority, and dropped if the network is full."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import zenoh
from zenoh.handlers import Callback

from followspot.transport.zenoh.terms import has_subscriber, undeclare


class ZenohPost:
    """`Post` to all subscribers of a key. Closing it leaves the session open."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._publisher = session.declare_publisher(
            key, congestion_control=zenoh.CongestionControl.DROP, priority=zenoh.Priority.BACKGROUND
        )

    @property
    def wanted(self) -> bool:
        """Whether the key has a subscriber."""
        return has_subscriber(self._publisher)

    def send(self, packet: bytes) -> None:
        """Put the packet, or drop it."""
        with suppress(zenoh.ZError):  # the session is closed
            self._publisher.put(packet)

    def close(self) -> None:
        """Undeclare the publisher."""
        undeclare([self._publisher])


def subscribe(session: zenoh.Session, key: str, take: Callable[[bytes], None]) -> zenoh.Subscriber[None]:
    """Receive packets until the subscriber is undeclared; take: gets each, in a thread of Zenoh."""

    def arrived(sample: zenoh.Sample) -> None:
        take(sample.payload.to_bytes())

    return session.declare_subscriber(key, Callback(arrived, indirect=False))
