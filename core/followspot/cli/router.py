"""`followspot router`: a Zenoh router that connects hosts of several networks."""

from __future__ import annotations

import argparse
import signal
import sys
import threading

from followspot.cli.agent_options import add_network_options, network_of
from followspot.errors import FollowspotError
from followspot.operating_system.ending_signals import ending_signals
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    add_network_options(parser, listens=True, routed=False)


def _run(args: argparse.Namespace) -> int:
    """Route messages between agents and operators that cannot connect directly; zenohd can do the same.

    Examples:
      followspot router --listen tls/0.0.0.0:7447 --certificates certs/hub
      followspot agent --name pc-left --router tls/router.example:7447 --certificates certs/pc-left
    """
    from followspot.security.rejected_peers import RejectedPeers
    from followspot.transport.zenoh.connections import Connections
    from followspot.transport.zenoh.session import close_session, connected, locators

    network = network_of(args, ("tcp/127.0.0.1:7447",), ())
    if network.certificates and network.own.role != "router":
        own = network.own
        raise FollowspotError(
            f"the certificate of {own.name} has the role {own.role}: others take nothing from such a router\n"
            "    make one where the authority is: followspot certs host NAME --role router"
        )
    over = threading.Event()
    for number in ending_signals():
        signal.signal(number, lambda *_: over.set())
    with RejectedPeers(_tell):
        session = connected(network, routes=True)
        try:
            _tell(f"router listens on {', '.join(locators(session))}")
            with Connections(session, network, _tell):
                over.wait()
        finally:
            close_session(session)
    return 0


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


COMMAND = Command("router", _configure, _run)
