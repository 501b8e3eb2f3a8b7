"""An agent whose host is in trouble refuses a run, and goes on."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from followspot.control.host import HostRefused, RunOrder
from followspot.control.lifecycle import ListRuns, PrepareRun
from followspot.control.plan_transfer import packed
from followspot.control.zenoh_rpc import RpcClient
from followspot.graph.compile import compile_graph
from followspot.host.agent import Agent
from followspot.host.agent_options import AgentOptions
from followspot.operator.new_order import new_order
from followspot.security.authority import create_authority
from followspot.transport.zenoh.edge import open_session
from followspot.transport.zenoh.network import LOOPBACK, UNPROVEN, Network
from followspot.worker.wiring import RunOptions

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


@pytest.fixture
def agent(tmp_path: Path) -> Iterator[Agent]:
    network = Network(listen=LOOPBACK)
    made = Agent(AgentOptions("left", network, runs=tmp_path / "runs", plugin_files=(str(TICKS),)))
    serving = threading.Thread(target=made.serve)
    serving.start()
    yield made
    made.stop()
    serving.join()


@pytest.fixture
def order(tmp_path: Path) -> RunOrder:
    """To run one stage on the host "left"."""
    (tmp_path / "g.yaml").write_text("graph: g\nstages:\n  a: {uses: ticks.count}\n")
    plan = compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS])
    plan = replace(plan, workers=tuple(replace(worker, host="left") for worker in plan.workers))
    order = new_order(plan, RunOptions(tmp_path), restart=False)
    return replace(order, plan=packed(plan, "left", tmp_path), out=None)


def test_a_run_whose_messages_the_host_cannot_read_is_refused(agent: Agent, order: RunOrder) -> None:
    """Every message would be refused, and a replay would wait for ever."""
    with open_session(connect=agent.locators) as session:
        client = RpcClient(session, UNPROVEN)
        other = replace(order, wire_version=order.wire_version + 1)
        with pytest.raises(HostRefused, match=r"messages of format 2, this host reads 1: install the same"):
            client.ask("left", PrepareRun(order=other), 30.0)
        assert client.ask("left", ListRuns(), 30.0) == []


def test_a_run_is_told_that_the_certificate_of_a_host_ends_soon(order: RunOrder, tmp_path: Path) -> None:
    certificates = create_authority(tmp_path / "certs").add("left", "camera", ["127.0.0.1"], days=5)
    network = Network(listen=("tls/127.0.0.1:0",), certificates=str(certificates))
    agent = Agent(AgentOptions("left", network, runs=tmp_path / "runs", plugin_files=(str(TICKS),)))
    try:
        agent.prepare(order)
        news = agent.agent_runs.agent_run(order.run).run.status().news
    finally:
        agent.stop()
        agent.serve()
    assert any(line.startswith("the certificate of left ends on ") for line in news), news


def test_a_run_that_cannot_be_prepared_does_not_end_the_agent(
    agent: Agent, order: RunOrder, tmp_path: Path
) -> None:
    blocked = tmp_path / "runs" / f"19700101-000000-{order.run}-left" / ".ledger"
    blocked.mkdir(parents=True)
    with open_session(connect=agent.locators) as session:
        client = RpcClient(session, UNPROVEN)
        with pytest.raises(HostRefused, match="Is a directory"):
            client.ask("left", PrepareRun(order=order), 30.0)
        assert client.ask("left", ListRuns(), 30.0) == []
        blocked.rmdir()
        client.ask("left", PrepareRun(order=order), 30.0)
        (listed,) = client.ask("left", ListRuns(), 30.0)
        assert (listed.run, listed.operator.user) == (order.run, order.operator.user)
        assert 0 <= listed.age_s < 600
        assert order.run in listed.folder
