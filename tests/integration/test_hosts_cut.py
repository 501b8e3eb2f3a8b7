"""Cables are pulled, routers and desks are away: the rest goes on, and what comes back takes part again."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from cuts import FAULTS, NAMES, Pair
from hosts import Hosts, namespaces_are_permitted
from running import STAGES, Finished, balanced, finish, write_graph
from test_agents import LIVE, grows, of_left

PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, stages: [a, more]}
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
    """The run ends as if nothing had happened, but for what was lost on the way."""
    finished = pair.ended()
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert balanced(finished.summary), finished.summary["edges"]
    assert not any("not from its sender" in line for line in finished.summary["warnings"])
    return finished


def test_a_cable_that_is_out_for_longer_than_anybody_waits_comes_back(hosts: Hosts) -> None:
    pair = Pair(hosts)
    pair.flows()
    with pair.away("cable"):
        time.sleep(12)
    pair.flows()
    finished = held(pair)
    news = finished.summary["warnings"]
    assert [line for line in news if line.startswith("host ")] == [
        "host pc-left does not answer",
        "host pc-left is back",
    ]
    assert f"pc-left: {SILENT}" in news
    assert any("the operator is back after" in line for line in news)
    produced = [edge["produced"] for edge in finished.summary["edges"]]
    away = [edge["away"] for edge in finished.summary["edges"]]
    assert min(away) > 0, "live sources go on, and what nobody gets is counted"
    assert min(produced) > max(away)


@pytest.mark.thorough
@pytest.mark.parametrize("fault", FAULTS)
def test_whatever_was_between_two_hosts_for_a_minute_they_take_part_again(hosts: Hosts, fault: str) -> None:
    pair = Pair(hosts, routed=fault.startswith("router"))
    pair.flows()
    with pair.away(fault):
        time.sleep(60)
    pair.flows()
    held(pair)


@pytest.mark.thorough
@pytest.mark.parametrize("fault", ["cable", "operator suspended"])
def test_what_a_host_gave_up_is_taken_up_again_and_the_news_say_so(hosts: Hosts, fault: str) -> None:
    pair = Pair(hosts, agent=("--operator-timeout", "5"))
    pair.flows()
    with pair.away(fault):
        assert pair.host_noted(GONE)
        assert pair.host_is_idle()
    pair.flows()
    news = held(pair).summary["warnings"]
    assert any("the agent had given the run up: its part of the run begins anew" in line for line in news)


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
