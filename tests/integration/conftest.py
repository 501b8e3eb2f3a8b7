"""Certificates of a few hosts, an agent with one of them, and two agents without certificates."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from tests.integration.certified import HOSTS, Agent, session
from tests.integration.hosts import free_port
from tests.integration.two_agents import TwoAgents

from followspot.security.authority import Authority, create_authority


@pytest.fixture(scope="module")
def certs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certs") / "ours"
    authority = create_authority(folder)
    for name, role in HOSTS.items():
        authority.add(name, role)  # type: ignore[arg-type]
    authority.add("gone", "operator")
    lost = (folder / "gone").rename(folder.parent / "gone")
    authority.remove("gone")
    assert lost.exists()
    yesterday = datetime.now(UTC) - timedelta(days=2)
    Authority(folder, yesterday).add("late", "operator", days=1)
    foreign = create_authority(folder.parent / "foreign")
    for name, role in HOSTS.items():
        foreign.add(name, role)  # type: ignore[arg-type]
    return folder


@pytest.fixture(scope="module")
def endpoint() -> str:
    return f"tls/127.0.0.1:{free_port()}"


@pytest.fixture(scope="module")
def agent(certs: Path, endpoint: str) -> Iterator[Agent]:
    with session(certs / "pc-right", listen=endpoint) as opened:
        agent = Agent(opened, "pc-right")
        yield agent
        agent.answers.close()


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[TwoAgents]:
    made = TwoAgents(tmp_path)
    made.agent("pc-left")
    made.agent("pc-right")
    yield made
    made.close()
