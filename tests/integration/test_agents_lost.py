"""Agents and operators that die: what goes on, what is resumed, and what the next run ends."""

from __future__ import annotations

import json

import pytest
import zenoh
from tests.commands import Started, command
from tests.integration.live_sum import grows, of_left
from tests.integration.running import (
    alive,
    balanced,
    wait_until,
    workers,
)
from tests.integration.two_agents import HOSTS, TwoAgents, ended

from followspot.operator.connect import run_here
from followspot.operator.discovery import operator_session
from followspot.transport.zenoh.network import Network


@pytest.mark.thorough
def test_a_restarted_agent_resumes_its_runs(hosts: TwoAgents) -> None:
    process = hosts.begin()
    out = hosts.folder / "out"
    grows(out / "ticks.csv", of_left, 5)
    hosts.agents["pc-left"].process.kill()
    hosts.agents["pc-left"].process.communicate()
    grows(out / "ticks.csv", lambda value: not of_left(value), 50)
    hosts.agent("pc-left")
    grows(out / "ticks.csv", of_left, 5)
    finished = ended(process, out)
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert any("the agent was restarted" in line for line in finished.summary["warnings"])
    assert balanced(finished.summary), finished.summary["edges"]


def test_a_run_of_n_frames_says_that_it_waits_for_a_lost_host_alone(hosts: TwoAgents) -> None:
    process = hosts.begin("--frames", "150")
    grows(hosts.folder / "out" / "ticks.csv")
    hosts.agents["pc-left"].process.kill()
    hosts.agents["pc-left"].process.communicate()
    waits = "the run waits for host pc-left alone: start the agent or mend the link there, or stop the run"
    run = run_here(str(process.pid))
    assert wait_until(lambda: waits in run.status().news)
    finished = ended(process, hosts.folder / "out")
    assert finished.code == 1
    assert f"warning: {waits}" in finished.errors
    assert finished.summary["errors"] == [
        "worker left was not there at the end: host pc-left does not answer"
    ]


def readers_of(session: zenoh.Session, port: str) -> list[str]:
    """The tokens of the readers of a port, as far as a session has heard of them."""
    heard = (str(reply.ok.key_expr) for reply in session.liveliness().get("followspot/**") if reply.ok)
    return [token for token in heard if f"/{port}/.reader/" in token]


def test_a_run_says_which_edge_stalls_because_another_peer_speaks_for_its_reader(hosts: TwoAgents) -> None:
    process = hosts.begin()
    out = hosts.folder / "out"
    grows(out / "ticks.csv")
    run = run_here(str(process.pid))
    begins = "more.out -> sum.numbers stalls: more has had no room to send for "
    with operator_session(Network(connect=tuple(hosts.endpoints.values()))) as session:
        assert wait_until(lambda: readers_of(session, f"{run.run}/pc-left/more/out")), (
            "nobody knows its reader"
        )
        (reader,) = readers_of(session, f"{run.run}/pc-left/more/out")
        forged = session.liveliness().declare_token(f"{reader.rpartition('/')[0]}/7")
        assert wait_until(lambda: any(line.startswith(begins) for line in run.status().faults()))
        forged.undeclare()
    assert wait_until(lambda: "more.out -> sum.numbers moves again" in run.status().news)
    finished = ended(process, out)
    assert f"warning: {begins}" in finished.errors


def killed(hosts: TwoAgents) -> Started:
    """A run whose operator was killed; both agents keep it running."""
    process = hosts.begin()
    grows(hosts.folder / "out" / "ticks.csv", of_left, 5)
    process.kill()
    process.communicate()
    return process


def test_the_next_run_ends_what_a_dead_operator_left_on_hosts(hosts: TwoAgents) -> None:
    killed(hosts)
    (left,) = workers(hosts.agents["pc-left"].process.pid)
    assert alive(left), "it might be a cable that is out"
    process = hosts.begin()
    assert wait_until(lambda: not alive(left), 60.0)
    grows(hosts.folder / "out" / "ticks.csv", of_left, 5)
    finished = ended(process, hosts.folder / "out")
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    said = "was left there by a process of this machine that has died; it was ended"
    for name in HOSTS:
        assert any(line.startswith(name) and line.endswith(said) for line in finished.summary["warnings"])


@pytest.mark.thorough
def test_attach_ends_what_a_dead_operator_left_on_hosts(hosts: TwoAgents) -> None:
    killed(hosts)
    done = command("attach", "--run", "graph", "--stop", "--json", *hosts.connect)
    assert json.loads(done.stdout)["edges"], done.stderr
    assert wait_until(lambda: not any(workers(agent.process.pid) for agent in hosts.agents.values()), 60.0)
