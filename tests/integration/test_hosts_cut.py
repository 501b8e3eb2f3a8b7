"""Cables are pulled and routers restarted: the rest goes on, and what comes back takes part again."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
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


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    with Hosts(tmp_path, ["desk", "pc-left", "middle"]) as made:
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


@pytest.mark.thorough
def test_a_host_that_is_cut_off_is_absent_until_its_cable_is_plugged_in_again(hosts: Hosts) -> None:
    hosts.agent("pc-left", "--plugin", STAGES)
    process = run(hosts, "--connect", hosts.endpoint("pc-left"))
    written = hosts.folder / "out" / "ticks.csv"
    grows(written, of_left, 5)
    hosts.link("pc-left", "down")
    grows(written, lambda value: not of_left(value), 600)
    hosts.link("pc-left", "up")
    grows(written, of_left, 5)
    finished = ended(process, hosts.folder / "out")
    assert any("host pc-left does not answer" in line for line in finished.summary["warnings"])
    assert balanced(finished.summary), finished.summary["edges"]


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
