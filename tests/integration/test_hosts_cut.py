"""Pulled cables, routers that are down, suspended operators: the run goes on, and hosts rejoin it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.integration.cuts import FAULTS, NAMES, Pair, host_noted
from tests.integration.hosts import Hosts, namespaces_are_permitted
from tests.integration.live_sum import LIVE, grows, of_left, values
from tests.integration.running import STAGES, Finished, balanced, finish, wait_until, workers, write_graph

PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, stages: [a, more]}
"""
REPLAY = """
a:    {uses: ticks.count, with: {count: 3000}}
b:    {uses: ticks.add, in: {number: a}, with: {sleep: 0.01}}
save: {uses: ticks.write, in: {number: b}}
"""
pytestmark = pytest.mark.skipif(
    not namespaces_are_permitted(), reason="this user may not make network namespaces"
)
SILENT = "the operator is silent: what runs here goes on for 3600 s"
GONE = "the operator was silent for 5 s: what runs here is ended"


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    with Hosts(tmp_path, NAMES) as made:
        yield made


def run(hosts: Hosts, *there: str) -> subprocess.Popen[str]:
    graph = write_graph(hosts.folder, LIVE)
    placement = hosts.folder / "hosts.yaml"
    placement.write_text(PLACEMENT)
    where = ("--placement", placement, *there, "--insecure")
    return hosts.start(
        "desk", "run", graph, "--plugin", STAGES, "--out", hosts.folder / "out", "--json", "--quiet", *where
    )


def ended(process: subprocess.Popen[str], out: Path) -> Finished:
    process.send_signal(signal.SIGINT)
    finished = finish(process, out)
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    return finished


def held(pair: Pair) -> Finished:
    """End the run; it is ok, and every message that did not arrive is counted as lost."""
    finished = pair.ended()
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert balanced(finished.summary), finished.summary["edges"]
    assert not any("not from its sender" in line for line in finished.summary["warnings"])
    return finished


def test_a_host_whose_cable_was_out_takes_part_again(hosts: Hosts) -> None:
    pair = Pair(hosts)
    pair.flows()
    with pair.away("cable"):
        assert pair.desk_noted("host pc-left does not answer")
        assert pair.host_noted(SILENT)
    pair.flows()
    finished = held(pair)
    news = finished.summary["warnings"]
    heard = [line for line in news if line.startswith("host ")]
    once = ["host pc-left does not answer", "host pc-left is back"]
    assert heard, "a pulled cable is told"
    assert heard == once * (len(heard) // 2), "a loaded machine may make a host silent more than once"
    assert f"pc-left: {SILENT}" in news
    assert any("the operator is back after" in line for line in news)
    produced = [edge["produced"] for edge in finished.summary["edges"]]
    away = [edge["away"] for edge in finished.summary["edges"]]
    assert min(away) > 0, "live sources go on, and what nobody gets is counted"
    assert min(produced) > max(away)


@pytest.mark.thorough
@pytest.mark.parametrize("fault", FAULTS)
def test_two_hosts_take_part_again_after_a_minute_apart(hosts: Hosts, fault: str) -> None:
    pair = Pair(hosts, routed=fault.startswith("router"))
    pair.flows()
    with pair.away(fault):
        time.sleep(60)
    pair.flows()
    held(pair)


@pytest.mark.thorough
@pytest.mark.parametrize("fault", ["cable", "operator suspended"])
def test_a_run_that_a_host_has_ended_is_resumed_and_the_news_say_so(hosts: Hosts, fault: str) -> None:
    pair = Pair(hosts, agent=("--operator-timeout", "5"))
    pair.flows()
    with pair.away(fault):
        assert pair.host_noted(GONE)
        assert pair.host_is_idle()
    pair.flows()
    news = held(pair).summary["warnings"]
    assert any("the agent had ended the run: its workers start again" in line for line in news)


@pytest.mark.thorough
def test_a_run_that_ends_while_a_cable_is_out_names_the_silent_host(hosts: Hosts) -> None:
    pair = Pair(hosts)
    pair.flows()
    with pair.away("cable"):
        assert pair.desk_noted("host pc-left does not answer")
        finished = pair.ended()
    assert finished.code == 1
    assert "Traceback" not in finished.errors
    assert finished.summary["errors"] == [
        "worker left was not there at the end: host pc-left does not answer"
    ]
    assert "host pc-left was not told that the run is over" in finished.errors
    assert not pair.host_is_idle(seconds=0.0)
    words = ("attach", "--stop", "--quiet", "--insecure", "--connect", hosts.endpoint("pc-left"))
    ending = hosts.start("desk", *words)
    ending.communicate(timeout=90)
    assert pair.host_is_idle()


@pytest.mark.thorough
@pytest.mark.parametrize("part", ["operator", "desk"])
def test_a_replay_with_suspended_processes_is_complete_or_fails(hosts: Hosts, part: str) -> None:
    """A source waits for a suspended reader; a reader whose whole host is silent misses messages."""
    agent = hosts.agent("pc-left", "--plugin", STAGES)
    graph = write_graph(hosts.folder, REPLAY)
    placement = hosts.folder / "hosts.yaml"
    placement.write_text(PLACEMENT.replace("[a, more]", "[a]"))
    words = ("run", graph, "--placement", placement, "--plugin", STAGES, "--out", hosts.folder / "out")
    there = ("--connect", hosts.endpoint("pc-left"), "--insecure")
    process = hosts.start("desk", *words, *there, "--json", "--quiet")
    written = hosts.folder / "out" / "ticks.csv"
    grows(written, more=100)
    stopped = [process.pid, *(workers(process.pid) if part == "desk" else ())]
    for pid in stopped:
        os.kill(pid, signal.SIGSTOP)
    noticed = wait_until(lambda: host_noted(hosts, SILENT) or not workers(agent.process.pid))
    for pid in stopped:
        os.kill(pid, signal.SIGCONT)
    assert noticed, "the host waits, or its part is over without the readers"
    finished = finish(process, hosts.folder / "out")
    if part == "operator":
        assert finished.code == 0, finished.summary["errors"]
        assert values(written) == list(range(1, 3001))
    else:
        assert finished.code == 1
        assert any("a.out -> b.number: " in line for line in finished.summary["errors"])


@pytest.mark.thorough
def test_a_router_between_hosts_may_be_restarted(hosts: Hosts) -> None:
    router = f"tcp/{hosts.address('middle')}:7447"
    words = ("router", "--listen", router, "--insecure")
    first = hosts.start("middle", *words)
    hosts.agent("pc-left", "--plugin", STAGES, router=router)
    process = run(hosts, "--router", router)
    written = hosts.folder / "out" / "ticks.csv"
    grows(written, of_left, 5)
    first.kill()
    first.communicate()
    grows(written, lambda value: not of_left(value), 100)
    hosts.start("middle", *words)
    grows(written, of_left, 5)
    finished = ended(process, hosts.folder / "out")
    assert balanced(finished.summary), finished.summary["edges"]
    assert not any("not from its sender" in line for line in finished.summary["warnings"])
