"""From the hosts that a plan names to the agents that stand there."""

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
from followspot.host.worker_process import Start, start_process
from followspot.operator.remote_host import RemoteHost
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import close_session, connected, locators

_DISCOVERY = 2.0
"""Seconds until nobody else can be expected to be discovered."""
_TIMEOUT = 5.0
"""Seconds for agents to be found; links between hosts may only just be made."""


@contextmanager
def operating(network: Network) -> Iterator[zenoh.Session]:
    """An operator's session. Raises FollowspotError."""
    session = connected(network)
    try:
        if network.discover:
            _await_anybody(session)
        yield session
    finally:
        close_session(session)


@dataclass(frozen=True)
class Agents:
    """`Others` that a session leads to. media: folder here whose files they have below their own."""

    client: RpcClient
    media: Path = Path()

    def names(self) -> Collection[str]:
        """Of all agents that are there."""
        return agents(self.client.session)

    def host(self, name: str) -> RemoteHost:
        """One of them."""
        return RemoteHost(self.client, name, self.media)


@contextmanager
def reached(
    plan: Plan, network: Network, media: Path, start: Start = start_process
) -> Iterator[tuple[Sequence[Host], Others]]:
    """The hosts of a plan: this one, and agents for the others; and whoever else there is.

    media: folder here whose files agents have below their own; start: of a worker here. Raises InputError
    where an agent is missing.
    """
    names = dict.fromkeys(worker.host for worker in plan.workers)
    with operating(network) as session:
        await_agents(session, [name for name in names if name], network)
        hub = (*locators(session), *network.connect)
        others = Agents(RpcClient(session, network.own), media)
        near = LocalHost("", network, hub, HostClock(others.client), start)
        yield [others.host(name) if name else near for name in names], others


def _await_anybody(session: zenoh.Session) -> None:
    """Return when somebody was discovered, or nobody is there."""
    deadline = time.monotonic() + _DISCOVERY
    while not session.info.peers_zid() and time.monotonic() < deadline:
        time.sleep(0.02)


def await_named(session: zenoh.Session, network: Network) -> None:
    """Return when as many agents are there as endpoints were named; some may be off, or not be agents."""
    deadline = time.monotonic() + _DISCOVERY
    while len(agents(session)) < len(network.connect) and time.monotonic() < deadline:
        time.sleep(0.02)


def await_agents(session: zenoh.Session, names: Sequence[str], network: Network) -> None:
    """Return when all these agents are there. Raises InputError naming those that are not."""
    deadline = time.monotonic() + _TIMEOUT
    while missing := sorted(set(names) - agents(session)):
        if time.monotonic() > deadline:
            found = ("on the local network",) * network.discover
            where = network.router or ", ".join((*network.connect, *found))
            raise InputError([_missing(name, where) for name in missing])
        time.sleep(0.1)


def _missing(name: str, where: str) -> Mistake:
    return Mistake(
        None,
        f'there is no agent for host "{name}" at {where or "any endpoint"}',
        f"start it there: followspot agent --name {name} --listen ENDPOINT, "
        "and name that endpoint here with --connect",
    )
