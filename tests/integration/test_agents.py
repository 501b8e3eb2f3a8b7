"""Agents: how operators find them, what they refuse, and what they say."""

from __future__ import annotations

import re
import resource
import signal
from pathlib import Path

import pytest
import zenoh
from tests.commands import command, launch
from tests.integration.hosts import Agent, free_port, near_agent
from tests.integration.running import (
    finish,
    start,
    words_of,
    write_graph,
)
from tests.integration.two_agents import TwoAgents

from followspot.control.zenoh_rpc import agents
from followspot.operator import discovery
from followspot.operator.discovery import await_named, operator_session
from followspot.transport.zenoh.network import Network


def test_a_run_refuses_agents_of_one_name_that_do_not_know_each_other(tmp_path: Path) -> None:
    for folder in ("one", "other"):
        (tmp_path / folder).mkdir()
    twins = [near_agent("twin", tmp_path / folder) for folder in ("one", "other")]
    graph = write_graph(tmp_path, "a: {uses: ticks.count}\nsave: {uses: ticks.write, in: {number: a}}\n")
    connect = [word for agent in twins for word in ("--connect", agent.endpoint)]
    done = command(*words_of(graph, tmp_path / "out", "--host", "twin", *connect))
    listed = command("runs", *connect)
    assert [agent.end() for agent in twins] == [0, 0]
    assert done.returncode == 2
    assert 'several agents are named "twin"' in done.stderr
    assert "end one of them, and start it again by another name" in done.stderr
    assert not list(tmp_path.glob("*/runs/*")), "neither began"
    assert 'several agents are named "twin", of which one is asked' in listed.stderr


def test_an_operator_waits_for_an_agent_that_is_slow_to_connect(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    agent = near_agent("pc-left", tmp_path)
    looks: list[set[str]] = []

    def look(session: zenoh.Session) -> set[str]:
        """The agents; this one goes on once it was not among them."""
        looks.append(agents(session))
        agent.signal(signal.SIGCONT)
        return looks[-1]

    monkeypatch.setattr(discovery, "agents", look)
    monkeypatch.setattr(discovery, "_DISCOVERY", 60.0)
    agent.signal(signal.SIGSTOP)
    network = Network(connect=(agent.endpoint,))
    try:
        with operator_session(network) as session:
            await_named(session, network)
            assert agents(session) == {"pc-left"}
        assert looks[0] == set()
    finally:
        agent.signal(signal.SIGCONT)
        assert agent.end() == 0


def test_a_host_without_an_agent_is_named_with_the_command_to_start_it(tmp_path: Path) -> None:
    hosts = TwoAgents(tmp_path)
    finished = finish(hosts.begin(), tmp_path / "out")
    assert finished.code == 2
    assert 'there is no agent for host "pc-left"' in finished.errors
    assert "followspot agent --name pc-right" in finished.errors


def test_a_host_whose_disk_is_full_says_where_the_outputs_were_to_go(hosts: TwoAgents) -> None:
    process = hosts.agents["pc-right"].process
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))
    finished = finish(hosts.begin(), hosts.folder / "out")
    assert finished.code == 1
    folder = re.escape(str(hosts.folder / "pc-right" / "runs"))
    why = rf"pc-right: the run cannot begin: File too large \(outputs go to {folder}/\S+-pc-right\)\n.*ulimit"
    assert re.search(why, finished.errors), finished.errors


def test_a_folder_that_takes_no_outputs_is_told_with_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    graph = write_graph(tmp_path, "a: {uses: ticks.count}\nsave: {uses: ticks.write, in: {number: a}}\n")
    agent = near_agent("pc-left", tmp_path, "--runs", tmp_path / "file")
    done = command(*words_of(graph, tmp_path / "out", "--host", "pc-left", "--connect", agent.endpoint))
    assert agent.end() == 0
    assert done.returncode == 1
    why = rf"pc-left: the run cannot begin: Not a directory \(outputs go to {tmp_path}/file/\S+\)\n.* --runs"
    assert re.search(why, done.stderr), done.stderr


def test_an_agent_beyond_loopback_needs_consent_and_says_what_it_means(tmp_path: Path) -> None:
    refused = command("agent", "--name", "pc-left", "--listen", "tcp/0.0.0.0:0")
    assert refused.returncode == 1
    assert "open to other hosts without protection" in refused.stderr
    agent = Agent(launch("agent", "--name", "pc-left", "--listen", "tcp/0.0.0.0:0", "--insecure"), tmp_path)
    assert "warning: --insecure" in agent.lines[0]
    assert agent.end() == 0


TIMES = """
from followspot import Stage
from followspot_file_ticks import Tick, tick


class Times(Stage):
    '''Multiples of numbers.'''

    def process(self, number: Tick) -> Tick:
        return tick({factor} * number.value)
"""


MULTIPLES = """
count: {uses: ticks.count}
times: {uses: times.times, in: {number: count}}
save:  {uses: ticks.write, in: {number: times}}
"""


def test_a_host_whose_code_of_a_plugin_file_is_another_is_named(tmp_path: Path) -> None:
    home, out = tmp_path / "pc-left", tmp_path / "out"
    home.mkdir()
    for folder, factor in ((tmp_path, 2), (home, 3)):
        (folder / "times.py").write_text(TIMES.format(factor=factor))
    (tmp_path / "hosts.yaml").write_text(
        "placement: hosts\nworkers: {left: {host: pc-left, stages: [times]}}\n"
    )
    agent = near_agent("pc-left", home, "--plugin", home / "times.py")
    hosts = ("--placement", str(tmp_path / "hosts.yaml"), "--connect", agent.endpoint)
    try:
        graph = write_graph(tmp_path, MULTIPLES)
        done = finish(start(graph, out, "--plugin", str(tmp_path / "times.py"), *hosts), out)
        assert done.code == 0, done.errors
        assert done.values() == [3 * number for number in range(10)]
        told = "pc-left: its code of times.py is not the operator's, so results may differ"
        assert any(warning.startswith(told) for warning in done.summary["warnings"])
    finally:
        agent.process.kill()
        agent.process.communicate()


def test_an_agent_says_that_it_waits_for_its_router_and_begins_when_that_is_there(tmp_path: Path) -> None:
    at = f"tcp/127.0.0.1:{free_port()}"
    with launch("agent", "--name", "pc-left", "--router", at, cwd=tmp_path) as agent:
        assert f"no router answers at {at}: nothing listens there; waiting for it" in agent.stderr.readline()
        with launch("router", "--listen", at, cwd=tmp_path) as router:
            assert "agent pc-left listens on" in agent.stderr.readline()
            for process in (agent, router):
                process.send_signal(signal.SIGINT)
                assert process.wait() == 0


def test_ctrl_c_ends_an_agent_that_waits_for_its_router() -> None:
    with launch("agent", "--name", "pc-left", "--router", f"tcp/127.0.0.1:{free_port()}") as agent:
        assert "waiting for it" in agent.stderr.readline()
        agent.send_signal(signal.SIGINT)
        assert agent.wait() == 130


def test_an_agent_says_to_what_it_is_not_connected_and_why_and_when_it_is(tmp_path: Path) -> None:
    at = f"tcp/127.0.0.1:{free_port()}"
    own = f"tcp/127.0.0.1:{free_port()}"
    words = ("agent", "--name", "pc-left", "--listen", own, "--connect", own, "--connect", at)
    with launch(*words, cwd=tmp_path) as agent:
        assert "listens on" in agent.stderr.readline()
        missing = f"not connected to {at}: nothing listens there; trying again\n"
        assert agent.stderr.readline() == missing
        for _ in range(2):  # the other host may end, and come back
            with launch("agent", "--name", "pc-right", "--listen", at, cwd=tmp_path) as other:
                assert agent.stderr.readline() == f"connected to {at}\n"
                other.send_signal(signal.SIGINT)
                assert other.wait() == 0
            assert agent.stderr.readline() == missing
        agent.send_signal(signal.SIGINT)
        assert agent.wait() == 0
        assert agent.stderr.read() == ""
        assert agent.stdout.read() == "", "Zenoh does not complain that it connects to itself"


def test_a_router_says_to_what_it_is_not_connected_and_why(tmp_path: Path) -> None:
    at, listen = (f"tcp/127.0.0.1:{free_port()}" for _ in range(2))
    with launch("router", "--listen", listen, "--connect", at, cwd=tmp_path) as router:
        assert "listens on" in router.stderr.readline()
        assert router.stderr.readline() == f"not connected to {at}: nothing listens there; trying again\n"
        router.send_signal(signal.SIGINT)
        assert router.wait() == 0
