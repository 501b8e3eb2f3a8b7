"""Discovery: finds the agents of the hosts that a plan names."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import zenoh

from followspot.control.host import Host, Others
from followspot.control.zenoh_rpc import RpcClient, agents
from followspot.errors import InputError, Mistake
from followspot.graph.plan import Plan
from followspot.host.clocks.host import HostClock
from followspot.host.local_host import LocalHost
from followspot.operator.remote.remote_host import RemoteHost
from followspot.transport.unreached import unreached
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import close_session, connected, locators

_DISCOVERY = 2.0
"""Seconds after which no further peer is expected to be discovered."""
_TIMEOUT = 5.0
"""Seconds that agents have to be found: links between hosts may still be connecting."""


@contextmanager
def operator_session(network: Network) -> Iterator[zenoh.Session]:
    """An operator's Zenoh session. Raises FollowspotError if it cannot connect."""
    session = connected(network)
    try:
        if network.discover:
            _await_peer(session)
        yield session
    finally:
        close_session(session)


@dataclass(frozen=True)
class Agents:
    """`Others` reached over Zenoh. media: local folder whose files agents have below their own --media."""

    client: RpcClient
    media: Path = Path()

    def names(self) -> Collection[str]:
        """The hosts of all agents that are alive."""
        return agents(self.client.session)

    def host(self, name: str) -> RemoteHost:
        """The host of this name. Raises InputError if several agents have it."""
        if self.client.has_twins(name):
            remedy = "end one of them, and start it again by another name: followspot agent --name NAME"
            raise InputError.of(f'several agents are named "{name}", and all would do what one is to', remedy)
        return RemoteHost(self.client, name, self.media)


@contextmanager
def discovered_hosts(
    plan: Plan, network: Network, media: Path, in_process: Collection[str] = ()
) -> Iterator[tuple[Sequence[Host], Others]]:
    """The hosts of a plan, the local one included, and the other hosts that may join the run.

    media: local folder whose files agents have below their own --media; in_process: workers of
    this host that are threads of this process.
    Raises InputError if an agent is missing, or several have one name.
    """
    names = dict.fromkeys(worker.host for worker in plan.workers)
    with operator_session(network) as session:
        await_agents(session, [name for name in names if name], network)
        await_named(session, network)  # of several agents of one name, all are heard by then
        hub = (*locators(session), *network.connect)
        others = Agents(RpcClient(session, network.own), media)
        near = LocalHost("", network, hub, HostClock(others.client), in_process)
        yield [others.host(name) if name else near for name in names], others


def _await_peer(session: zenoh.Session) -> None:
    """Return when a peer was discovered, or after `_DISCOVERY` seconds."""
    deadline = time.monotonic() + _DISCOVERY
    while not session.info.peers_zid() and time.monotonic() < deadline:
        time.sleep(0.02)


def await_named(session: zenoh.Session, network: Network) -> None:
    """Return when there are as many agents as named endpoints, or after `_DISCOVERY` seconds.

    Some endpoints may be down, or belong to a router.
    """
    deadline = time.monotonic() + _DISCOVERY
    while len(agents(session)) < len(network.connect) and time.monotonic() < deadline:
        time.sleep(0.02)


def await_agents(session: zenoh.Session, names: Sequence[str], network: Network) -> None:
    """Return when all these agents are alive. Raises InputError naming those that are missing."""
    deadline = time.monotonic() + _TIMEOUT
    while missing := sorted(set(names) - agents(session)):
        if time.monotonic() > deadline:
            why = unreached(network.connect, network.certificates) or _unheard(network)
            raise InputError([_missing(name, searched_places(network), why) for name in missing])
        time.sleep(0.1)


def searched_places(network: Network) -> str:
    """The places where a network looks for agents, as text."""
    found = ("any address of the local network",) * network.discover
    return network.router or ", ".join((*network.connect, *found)) or "any endpoint"


def _unheard(network: Network) -> str:
    """What to look for if endpoints take the certificate of this host, and no agent is heard all the same."""
    if not (network.connect and network.certificates):
        return ""
    return f"that answers: is {network.own.name} in hosts.json there, and is this the name of its agent?"


def _missing(name: str, where: str, why: str) -> Mistake:
    """why: what keeps this host from the endpoints, "" if nothing does."""
    return Mistake(
        None,
        f'there is no agent for host "{name}" at {where}',
        f"{why}\n    " * bool(why) + f"start it there: followspot agent --name {name} --listen ENDPOINT, "
        "and name that endpoint here with --connect",
    )
