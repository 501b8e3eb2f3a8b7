"""The network as seen from one host: loopback, multicast, ports, Zenoh."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator

from followspot_doctor.finding import Finding, doubtful, fine, wrong

PORTS = {7447: "a router", 7450: "an agent", 8777: "the page"}
"""Default ports and their servers."""
GROUP = "239.255.77.7"
TIMEOUT = 2.0


def loopback() -> Iterator[Finding]:
    """A datagram to oneself."""
    try:
        with _receiver("127.0.0.1") as end, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(b"followspot", end.getsockname())
            end.recv(64)
    except OSError as error:
        yield wrong("loopback", f"a datagram to 127.0.0.1 does not arrive: {error}", "ip link set lo up")
    else:
        yield fine("loopback", "a datagram to 127.0.0.1 arrives")


def multicast() -> Iterator[Finding]:
    """A multicast datagram; agents discover each other by multicast unless endpoints are given."""
    try:
        with _receiver("") as end, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            membership = socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0")  # noqa: S104  any network card
            end.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
            sender.sendto(b"followspot", (GROUP, end.getsockname()[1]))
            end.recv(64)
    except OSError as error:
        remedy = "name endpoints, as in --connect tcp/HOST:7447; of other hosts nothing is discovered"
        yield doubtful("multicast", f"a datagram to a group does not come back: {error}", remedy)
    else:
        yield fine("multicast", "a datagram to a group comes back")


def ports() -> Iterator[Finding]:
    """The ports that `followspot router`, `agent` and `run --dashboard` listen on."""
    for port, whose in PORTS.items():
        name = f"port {port}"
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                remedy = f"{whose} runs here already, or another program; ss -ltnp tells which"
                yield doubtful(name, "is taken", remedy)
            else:
                yield fine(name, f"is free for {whose}")


def zenoh_session() -> Iterator[Finding]:
    """Zenoh opens and closes a session on loopback."""
    try:
        from followspot.transport.zenoh.session import open_session

        started = time.monotonic()
        open_session().close()  # type: ignore[no-untyped-call]
    except Exception as error:
        yield wrong(
            "zenoh", f"no session: {' '.join(str(error).split())}", "pip install --upgrade eclipse-zenoh"
        )
    else:
        yield fine("zenoh", f"a session opens, in {time.monotonic() - started:.2f} s")


def _receiver(address: str) -> socket.socket:
    end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    end.settimeout(TIMEOUT)
    end.bind((address, 0))
    return end
