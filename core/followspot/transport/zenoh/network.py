"""The network of a Zenoh session: endpoints and certificates; this module does not import Zenoh."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from followspot.errors import FollowspotError
from followspot.transport.host_registry import read_certificates
from followspot.transport.keys import OPERATOR

LOOPBACK = ("tcp/127.0.0.1:0",)
"""Listen on a free port that no other host can reach."""
AGENT = ("tcp/127.0.0.1:7450",)
"""Default port of agents."""
_SECURE = "tls/"
_EVERYWHERE = "0.0.0.0:0"
_FORM = re.compile(r"(?:tcp|tls)/(?:\[[^/?#\[\]]+\]|[^/?#:\[\]]+):(?P<port>[0-9]{1,5})(?:[?#].*)?")
"""Zenoh's other protocols lose messages, cannot carry a run, or have no certificates here."""
_LARGEST_PORT = (1 << 16) - 1


class Own(NamedTuple):
    """Role and name of a session's host."""

    role: str
    name: str


UNPROVEN = Own(OPERATOR, "anyone")
"""Without certificates every peer may do everything."""


@dataclass(frozen=True)
class Network:
    """The endpoints where a session listens and to which it connects, and its protection.

    listen, connect: endpoints such as ``tcp/192.168.0.7:7447``; connections are retried until they succeed.
    certificates: folder as `followspot certs host` makes it, empty for none;
    insecure: whether the user accepts plain endpoints that other hosts reach;
    router: endpoint of a router through which all goes, in place of listening and connecting; "" for none;
    discover: whether to look for others on the local network, and to be found there.
    """

    listen: tuple[str, ...] = LOOPBACK
    connect: tuple[str, ...] = ()
    certificates: str = ""
    insecure: bool = False
    router: str = ""
    discover: bool = False

    @property
    def endpoints(self) -> tuple[str, ...]:
        """All endpoints that this session opens."""
        return (self.router,) if self.router else (*self.listen, *self.connect)

    @property
    def others(self) -> tuple[str, ...]:
        """The endpoints to connect to, without this session's own: all hosts may have one list."""
        return tuple(endpoint for endpoint in self.connect if endpoint not in self.listen)

    def check_endpoints(self) -> None:
        """Raise FollowspotError if an endpoint has another form or protocol, or its port is too large."""
        for endpoint in self.endpoints:
            if not _FORM.fullmatch(endpoint) or _port(endpoint) > _LARGEST_PORT:
                raise FollowspotError(
                    f"{endpoint!r} is no endpoint; write PROTOCOL/HOST:PORT with tcp or tls, for example "
                    "tcp/127.0.0.1:7450 or tls/192.168.0.7:7450"
                )

    @property
    def leads_somewhere(self) -> bool:
        """Whether this session connects to others, and does not only wait for them."""
        return bool(self.connect or self.router)

    @property
    def public(self) -> bool:
        """Whether others can know where to find this session: at a fixed port, or a router."""
        return bool(self.router) or any(_any_port(endpoint) != endpoint for endpoint in self.listen)

    @property
    def secured(self) -> tuple[str, ...]:
        """Endpoints that TLS protects."""
        return tuple(e for e in self.endpoints if e.startswith(_SECURE))

    @property
    def exposed(self) -> tuple[str, ...]:
        """Endpoints beyond this host that TLS does not protect."""
        found = ("the local network (--discover)",) if self.discover and not self.certificates else ()
        return (*(e for e in self.endpoints if not e.startswith(_SECURE) and not _near(e)), *found)

    @property
    def findable(self) -> bool:
        """Whether to announce on the local network where this session listens."""
        return not self.router and not all(_near(endpoint) for endpoint in self.listen)

    @property
    def own(self) -> Own:
        """Role and name as certified, else an operator of any name. Raises FollowspotError."""
        if not self.certificates:
            return UNPROVEN
        own = read_certificates(Path(self.certificates)).own
        return Own(own.role, own.name)

    def for_worker(self, hub: Sequence[str]) -> Network:
        """The network of a worker: free ports at these endpoints, connected to the hub's locators."""
        listen = tuple(_any_port(e) for e in self.listen)
        return replace(self, listen=listen, connect=tuple(hub), discover=False)


def secured(endpoints: Sequence[str]) -> tuple[str, ...]:
    """The endpoints, those of loopback over TLS."""
    return tuple(e.replace("tcp/", _SECURE, 1) if _near(e) else e for e in endpoints)


def everywhere(certificates: str) -> tuple[str, ...]:
    """Listen on a free port of all addresses of this host, for peers that discover it."""
    return ((_SECURE if certificates else "tcp/") + _EVERYWHERE,)


def _near(endpoint: str) -> bool:
    """Whether only this host reaches the endpoint; False if it is no address: Zenoh refuses that."""
    host = endpoint.partition("/")[2].partition("#")[0].rpartition(":")[0].strip("[]")
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host in ("", "localhost")


def _port(endpoint: str) -> int:
    """The port of an endpoint; 0 if it has none."""
    found = _FORM.fullmatch(endpoint)
    return int(found["port"]) if found else 0


def _any_port(endpoint: str) -> str:
    address, _, options = endpoint.partition("#")
    return address.rpartition(":")[0] + ":0" + (f"#{options}" if options else "")
