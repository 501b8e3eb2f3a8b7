"""From the hosts that a plan names to the agents that stand there."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import zenoh

from followspot.deploy.clocks.host import HostClock
from followspot.deploy.far_host import FarHost
from followspot.deploy.host import Host
from followspot.deploy.host_run import HostRun
from followspot.deploy.requests import Asker, agents
from followspot.errors import InputError, Mistake
from followspot.graph.plan import Plan
from followspot.transport.zenoh_network import Network
from followspot.transport.zenoh_session import connected, locators

_PATIENCE = 5.0
"""Seconds for agents to be found; links between hosts may only just be made."""


@contextmanager
def operating(network: Network) -> Iterator[zenoh.Session]:
    """An operator's session. Raises FollowspotError."""
    session = connected(network)
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


@contextmanager
def reached(plan: Plan, network: Network, media: Path) -> Iterator[Sequence[Host]]:
    """The hosts of a plan: this one where it has workers, and agents for the others.

    media: folder here whose files agents have below their own. Raises InputError where an agent is missing.
    """
    names = dict.fromkeys(worker.host for worker in plan.workers)
    with operating(network) as session:
        await_agents(session, [name for name in names if name], network)
        hub = (*locators(session), *network.connect)
        asker = Asker(session, network.own)
        near = HostRun("", network, hub, HostClock(asker))
        yield [FarHost(asker, name, media) if name else near for name in names]


def await_agents(session: zenoh.Session, names: Sequence[str], network: Network) -> None:
    """Return when all these agents are there. Raises InputError naming those that are not."""
    deadline = time.monotonic() + _PATIENCE
    while missing := sorted(set(names) - agents(session)):
        if time.monotonic() > deadline:
            where = network.router or ", ".join(network.connect)
            raise InputError([_missing(name, where) for name in missing])
        time.sleep(0.1)


def _missing(name: str, where: str) -> Mistake:
    return Mistake(
        None,
        f'there is no agent for host "{name}" at {where or "any endpoint"}',
        f"start it there: followspot agent --name {name} --listen ENDPOINT, "
        "and name that endpoint here with --connect",
    )
