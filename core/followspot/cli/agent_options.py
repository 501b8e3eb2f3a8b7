"""Options of every command that communicates with other hosts."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from followspot.transport.zenoh.network import Network

_INSECURE = (
    "warning: --insecure: any program that reaches {} can see every picture, start and stop runs, and "
    "pretend to be a camera; use it on a private network only"
)


def add_network_options(
    parser: argparse.ArgumentParser, *, listens: bool = False, routed: bool = True
) -> None:
    """Add the network options.

    listens: add --listen, for commands that other hosts connect to; routed: add --discover and --router.
    """
    group = parser.add_argument_group("other hosts")
    if listens:
        group.add_argument(
            "--listen",
            action="append",
            default=[],
            metavar="ENDPOINT",
            help="endpoint to listen on, for example tls/192.168.0.7:7450 (default: loopback)",
        )
    group.add_argument(
        "--connect",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="endpoint of an agent; the agents that it knows are found, too; repeatable",
    )
    if routed:
        group.add_argument(
            "--discover",
            action="store_true",
            help="find agents on the local network, and let them find this host, instead of naming endpoints",
        )
        group.add_argument(
            "--router",
            metavar="ENDPOINT",
            help="endpoint of a router that passes on all messages, if hosts cannot reach each other",
        )
    group.add_argument(
        "--certificates",
        metavar="DIR",
        help="folder with the certificate of this host, made by followspot certs; tls/ needs it",
    )
    group.add_argument(
        "--insecure", action="store_true", help="allow endpoints on other hosts without TLS, for tests"
    )


def network_of(
    args: argparse.Namespace, listen: Sequence[str] | None = None, connect: Sequence[str] | None = None
) -> Network:
    """The network that the options describe; prints a warning about endpoints that nothing protects, and of
    a certificate that ends soon.

    listen, connect: endpoints if the options name none; by default a free port of this host, and its agent.
    Raises FollowspotError if an endpoint is none.
    """
    from followspot.transport.zenoh.network import AGENT, LOOPBACK, Network, secured

    listen = tuple(getattr(args, "listen", None) or (LOOPBACK if listen is None else listen))
    discover = getattr(args, "discover", False)
    connect = tuple(args.connect or (() if discover else AGENT if connect is None else connect))
    router = getattr(args, "router", None) or ""
    if args.certificates:  # loopback uses TLS, too: certificates identify the peers
        listen, connect, (router,) = secured(listen), secured(connect), secured([router])
    network = Network(listen, connect, args.certificates or "", args.insecure, router, discover)
    network.check_endpoints()
    if network.insecure and network.exposed:
        print(_INSECURE.format(", ".join(network.exposed)), file=sys.stderr, flush=True)
    if network.certificates:
        _warn_of_end(Path(network.certificates))
    return network


def _warn_of_end(folder: Path) -> None:
    """Print that the certificate of this host ends soon."""
    from followspot.transport.host_registry import expiring_soon

    if ending := expiring_soon(folder):
        print(f"warning: {ending}", file=sys.stderr, flush=True)
