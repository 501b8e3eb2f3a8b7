"""Sends orders to all hosts of a run, also to those that are prepared or join later."""

from __future__ import annotations

from collections.abc import Iterable
from threading import Lock

from followspot.control.host import Host
from followspot.control.relay import Relayed


class OrderRelay:
    """Sends orders for workers to every host that is prepared. Safe from any thread.

    prepared: hosts that have their workers already.
    """

    def __init__(self, prepared: Iterable[Host]) -> None:
        self._prepared = list(prepared)
        self._kept: list[Relayed] = []
        """Orders that each host gets after its preparation."""
        self._last: dict[type[Relayed], Relayed] = {}
        """The last order of each type."""
        self._lock = Lock()

    def send(self, order: Relayed, *, keep: bool) -> None:
        """Send an order to all prepared hosts. keep: whether hosts that are prepared later get it, too.

        Raises FollowspotError if the order does not fit the last one of its type.
        """
        with self._lock:
            if (before := self._last.get(type(order))) is not None:
                order.check_after(before)
            self._last[type(order)] = order
            if keep:
                self._kept = order.standing(self._kept)
            for host in self._prepared:
                host.ask(order)

    def add(self, host: Host) -> None:
        """Send the kept orders to a host that has just been prepared; from now on it gets all others."""
        with self._lock:
            self._prepared.append(host)
            for order in self._kept:
                host.ask(order)
