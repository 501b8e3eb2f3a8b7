"""Operators and other processes of the user cannot make a worker send to or open what is not granted."""

from __future__ import annotations

import signal
import socket
from pathlib import Path

import pytest
from tests.integration.hosts import near_agent
from tests.integration.running import finish, start, wait_until, write_graph

from followspot.control.tapping import Tapping
from followspot.errors import FollowspotError
from followspot.operator.connect import runs_here

HOST = "pc-left"
TELLS = """
a: {{uses: ticks.count, with: {{count: 5}}}}
tell: {{uses: sinks.udp_json, in: {{message: a}}, with: {{{}}}}}
"""
PLACEMENT = f"placement: hosts\nworkers:\n  left: {{host: {HOST}, stages: [a, tell]}}\n"


@pytest.mark.parametrize(
    ("receiver", "options", "says"),
    [
        pytest.param("host: 203.0.113.9", (), "would send to 203.0.113.9", marks=pytest.mark.thorough),
        ("host: 203.0.113.9", ("--send-to", "203.0.113.8"), "agent --send-to 203.0.113.9"),
        ("host: 127.0.0.1, port: {port}", (), ""),
        pytest.param(
            "host: 127.0.0.2, port: {port}", ("--send-to", "203.0.113.9"), "", marks=pytest.mark.thorough
        ),
    ],
)
def test_an_agent_sends_where_its_owner_allows(
    tmp_path: Path, receiver: str, options: tuple[str, ...], says: str
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.bind(("0.0.0.0", 0))
        heard.settimeout(60)
        graph = write_graph(tmp_path, TELLS.format(receiver.format(port=heard.getsockname()[1])))
        (tmp_path / "hosts.yaml").write_text(PLACEMENT)
        agent = near_agent(HOST, tmp_path, *options)
        try:
            connected = ("--placement", str(tmp_path / "hosts.yaml"), "--connect", agent.endpoint)
            finished = finish(start(graph, tmp_path / "out", *connected), tmp_path / "out")
            assert (finished.code != 0) == bool(says), finished.errors
            assert says in finished.errors
            if not says:
                assert b'"value":0' in heard.recv(1 << 16)
        finally:
            agent.process.kill()
            agent.process.communicate()


def test_a_tap_cannot_make_a_run_send_elsewhere(tmp_path: Path) -> None:
    """The run's own graph may send anywhere; a tap placed by another process may not."""
    graph = write_graph(tmp_path, "a: {uses: ticks.live, with: {count: 1000000}}")
    process = start(graph, tmp_path / "out")
    found = []

    def begun() -> bool:
        found[:] = [run for run in runs_here() if run.pid == process.pid and run.graph]
        return bool(found)

    assert wait_until(begun, 60)
    for uses, params in (("sinks.udp_json", {"host": "203.0.113.9"}), ("sinks.csv", {"path": "x.csv"})):
        with pytest.raises(FollowspotError, match="it is no tap"):
            found[0].tap([Tapping("a.out", uses, params)])
    found[0].tap([Tapping("a.out", "dashboard.tap", {"folder": str(tmp_path), "port": "a.out"})])
    process.send_signal(signal.SIGINT)
    finished = finish(process, tmp_path / "out")
    assert finished.code == 0, finished.errors
