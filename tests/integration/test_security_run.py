"""A whole run between an operator and an agent with certificates, over TLS on loopback."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.commands import command, launch
from tests.integration.hosts import Agent, free_port
from tests.integration.running import balanced

ROOT = Path(__file__).parent.parent.parent
GRAPH = ROOT / "graphs" / "glowballs.yaml"
ROOM = ROOT / "graphs" / "rooms" / "simulated6.yaml"


@pytest.fixture
def certs(tmp_path: Path) -> Path:
    folder = tmp_path / "certs"
    command("certs", "init", "--dir", folder, check=True)
    for name, role in (("desk", "operator"), ("pc-left", "camera"), ("pc-right", "camera")):
        command("certs", "host", name, "--role", role, "--dir", folder, check=True)
    return folder


def spread(room: Path, to: Path) -> Path:
    """The room with two cameras on the other host."""
    lines = []
    for line in room.read_text().splitlines():
        lines.append(line)
        if line in ("  cam0:", "  cam3:"):
            lines.append("    host: pc-left")
    to.write_text("\n".join(lines) + "\n")
    return to


def test_an_operator_runs_a_graph_over_tls_and_a_camera_host_may_not(certs: Path, tmp_path: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    words = ["agent", "--name", "pc-left", "--listen", endpoint, "--certificates", certs / "pc-left"]
    agent = Agent(launch(*words, cwd=tmp_path), tmp_path)
    room = spread(ROOM, tmp_path / "room.yaml")
    run = ["run", GRAPH, "--room", room, "--frames", "20", "--placement", "camera", "--json", "--quiet"]
    try:
        there = ["--connect", endpoint, "--certificates"]
        alone = tmp_path / "alone"
        command("run", GRAPH, "--room", room, "--frames", "20", "--out", alone, "--quiet", check=True)
        done = command(*run, *there, certs / "desk", "--out", tmp_path / "two", check=True)
        summary = json.loads(done.stdout)
        assert balanced(summary)
        assert "zenoh" in {edge["kind"] for edge in summary["edges"]}
        assert (tmp_path / "two" / "tracks.csv").read_bytes() == (alone / "tracks.csv").read_bytes()

        refused = command(*run, *there, certs / "pc-right", "--out", tmp_path / "no")
        assert refused.returncode != 0
        assert "camera pc-right may not prepare_run; operators may" in refused.stderr
        assert not (tmp_path / "no" / "tracks.csv").exists()
    finally:
        agent.process.terminate()
        _, log = agent.process.communicate(timeout=30)
    assert "refused (role" in log
    assert "pc-right" in log
    assert "requests refused: " in log.splitlines()[-1]


def test_an_agent_does_not_pass_for_another_host(certs: Path) -> None:
    done = command("agent", "--name", "pc-left", "--certificates", certs / "pc-right")
    assert done.returncode == 1
    assert "the certificate is that of pc-right" in done.stderr
