"""Says to which named endpoints a session is not connected, why, and when it is: Zenoh only tries again."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Self

import zenoh

from followspot.transport.unreached import reach
from followspot.transport.zenoh.network import Network

_POLL = 0.5
"""Seconds between two looks at the links of the session."""
_SHORTEST_WAIT, _LONGEST_WAIT = 1.0, 30.0
"""Seconds between two attempts to reach an endpoint; the wait doubles from the one to the other."""


@dataclass
class _Endpoint:
    """An endpoint, and what was said of it.

    told: why it is out of reach, "" if that was not said; due: monotonic time of the next attempt, s;
    wait: until the one after it, s.
    """

    name: str
    told: str = ""
    due: float = 0.0
    wait: float = _SHORTEST_WAIT


class Connections:
    """Looks in a thread of its own at the endpoints to which a session is to connect, until it is closed."""

    def __init__(self, session: zenoh.Session, network: Network, log_line: Callable[[str], None]) -> None:
        """log_line: gets a line for each new reason, and for each connection after one."""
        self._session, self._log_line = session, log_line
        self._certificates = network.certificates
        named = [network.router] if network.router else network.others
        self._endpoints = [_Endpoint(name) for name in named]
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="connections", daemon=True)
        if named:
            self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Say nothing more; an attempt that is under way may go on for some seconds."""
        self._over.set()

    def _watch(self) -> None:
        while not self._over.is_set():
            for endpoint in self._endpoints:
                with suppress(zenoh.ZError):  # the session is closed
                    self._look(endpoint)
            self._over.wait(_POLL)

    def _look(self, endpoint: _Endpoint) -> None:
        if self._linked(endpoint.name):
            self._connected(endpoint)
        elif time.monotonic() >= endpoint.due:
            found = reach(endpoint.name, self._certificates)
            if found.zid in self._peers():  # by a link that the other end opened, or to another address of it
                self._connected(endpoint)
            elif found.fault not in ("", endpoint.told):
                endpoint.told = found.fault
                self._say(f"not connected to {endpoint.name}: {found.fault}; trying again")
            endpoint.due = time.monotonic() + endpoint.wait
            endpoint.wait = min(2 * endpoint.wait, _LONGEST_WAIT)

    def _connected(self, endpoint: _Endpoint) -> None:
        if endpoint.told:
            self._say(f"connected to {endpoint.name}")
        endpoint.told, endpoint.wait = "", _SHORTEST_WAIT

    def _say(self, line: str) -> None:
        if not self._over.is_set():
            self._log_line(line)

    def _linked(self, name: str) -> bool:
        """Whether the session has opened a link to the endpoint."""
        there = {str(link.dst) for link in self._session.info.links()}
        return bool(there) and not there.isdisjoint(_locators(name))

    def _peers(self) -> set[str]:
        """The ids of all to which the session is connected, and its own."""
        return {str(link.zid) for link in self._session.info.links()} | {str(self._session.zid())}


def _locators(name: str) -> set[str]:
    """The endpoint as Zenoh names the other end of a link: by the addresses of its host."""
    protocol, _, rest = name.partition("/")
    host, _, port = rest.partition("#")[0].partition("?")[0].rpartition(":")
    with suppress(OSError):
        found = socket.getaddrinfo(host.strip("[]"), port, type=socket.SOCK_STREAM)
        addresses = {str(address[0]) for *_, address in found}
        return {f"{protocol}/[{a}]:{port}" if ":" in a else f"{protocol}/{a}:{port}" for a in addresses}
    return set()
