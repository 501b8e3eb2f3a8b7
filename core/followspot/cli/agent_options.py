"""The options of every command that speaks with other hosts."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from followspot.transport.zenoh.network import Network

_INSECURE = (
    "warning: --insecure: whoever reaches {} can watch every picture, start and stop runs on it, and "
    "pass for a camera; use it only on a network of your own"
)


def add_network_options(
    parser: argparse.ArgumentParser, *, listens: bool = False, routed: bool = True
) -> None:
    """The options that lead to other hosts; --listen where others connect to this command."""
    group = parser.add_argument_group("other hosts")
    if listens:
        group.add_argument(
            "--listen",
            action="append",
            default=[],
            metavar="ENDPOINT",
            help="where others reach this one, for example tls/192.168.0.7:7450 (default: this host alone)",
        )
    group.add_argument(
        "--connect",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="an agent to connect to; those that it knows are found through it; repeatable",
    )
    if routed:
        group.add_argument(
            "--discover",
            action="store_true",
            help="find agents on the local network, and be found there, instead of naming endpoints",
        )
        group.add_argument(
            "--router",
            default="",
            metavar="ENDPOINT",
            help="a router through which everything goes, where hosts cannot reach each other",
        )
    group.add_argument(
        "--certificates",
        default="",
        metavar="DIR",
        help="folder of this host as followspot certs made it, for tls/",
    )
    group.add_argument(
        "--insecure", action="store_true", help="allow endpoints beyond this host without TLS: for tests"
    )


def network_of(
    args: argparse.Namespace, listen: Sequence[str] | None = None, connect: Sequence[str] | None = None
) -> Network:
    """The network that the options describe; prints a warning about endpoints that nothing protects.

    listen, connect: endpoints if the options name none; by default a free port of this host, and its agent.
    """
    from followspot.transport.zenoh.network import AGENT, LOOPBACK, Network, secured

    listen = tuple(getattr(args, "listen", None) or (LOOPBACK if listen is None else listen))
    discover = getattr(args, "discover", False)
    connect = tuple(args.connect or (() if discover else AGENT if connect is None else connect))
    router = getattr(args, "router", "")
    if args.certificates:  # what is open to this host alone is secured, too: certificates tell who is who
        listen, connect, (router,) = secured(listen), secured(connect), secured([router])
    network = Network(listen, connect, args.certificates, args.insecure, router, discover)
    if network.insecure and network.exposed:
        print(_INSECURE.format(", ".join(network.exposed)), file=sys.stderr, flush=True)
    return network
