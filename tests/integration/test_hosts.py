"""Three hosts, six cameras two by two: the tracks are those of one process, bit for bit.

One agent is named, the other one is found.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.commands import command
from tests.datasets import dataset, needs_data
from tests.integration.hosts import Hosts, namespaces_are_permitted
from tests.integration.running import balanced

ROOT = Path(__file__).parent.parent.parent
GRAPH = ROOT / "graphs" / "glowballs.yaml"
DATA = dataset("glowballs-dev")
RECORDING = DATA / "dev3"
FRAMES = "30"
PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, cameras: [cam0, cam1]}
  right: {host: pc-right, cameras: [cam2, cam3]}
"""
HOST_OF = {"cam0": "pc-left", "cam1": "pc-left", "cam2": "pc-right", "cam3": "pc-right"}
"""The other two cameras are on the operator's own host."""

pytestmark = pytest.mark.skipif(
    not namespaces_are_permitted(), reason="this user may not make network namespaces"
)


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    with Hosts(tmp_path, ["desk", "pc-left", "pc-right"]) as made:
        yield made


def spread(room: Path, to: Path) -> Path:
    """The room with four of its cameras on other hosts, by one more line for each."""
    lines = []
    for line in room.read_text().splitlines():
        lines.append(line)
        camera = line.strip().rstrip(":")
        if camera in HOST_OF and line.startswith("  cam"):
            lines.append(f"    host: {HOST_OF[camera]}")
    to.write_text("\n".join(lines) + "\n")
    return to


def tracks_in_one_process(room: Path, out: Path) -> bytes:
    command("run", GRAPH, "--room", room, "--frames", FRAMES, "--out", out, "--quiet", check=True)
    return (out / "tracks.csv").read_bytes()


def tracks_on_three_hosts(
    hosts: Hosts, room: Path, out: Path, placement: str | Path, *options: str | Path
) -> bytes:
    words = ["run", GRAPH, "--room", room, "--frames", FRAMES, "--out", out, "--json", "--quiet"]
    there = ("--connect", hosts.endpoint("pc-left"), "--discover", "--insecure")
    process = hosts.start("desk", *words, "--placement", placement, *there, *options)
    stdout, stderr = process.communicate(timeout=90)
    assert process.returncode == 0, stderr + stdout
    summary = json.loads(stdout)
    assert balanced(summary)
    assert "zenoh" in {edge["kind"] for edge in summary["edges"]}
    return (out / "tracks.csv").read_bytes()


@pytest.mark.thorough
def test_a_simulated_room_on_three_hosts_gives_the_tracks_of_one_process(
    hosts: Hosts, tmp_path: Path
) -> None:
    room = spread(ROOT / "graphs" / "rooms" / "simulated6.yaml", tmp_path / "room.yaml")
    hosts.agent("pc-left")
    hosts.agent("pc-right", "--discover")
    alone = tracks_in_one_process(room, tmp_path / "alone")
    assert len(alone.splitlines()) > 60
    assert tracks_on_three_hosts(hosts, room, tmp_path / "three", "camera") == alone


@needs_data("glowballs-dev")
def test_a_recording_on_three_hosts_gives_the_tracks_of_one_process(hosts: Hosts, tmp_path: Path) -> None:
    room = tmp_path / "imported.yaml"
    command("room", "import", DATA / "calibration.json", "--videos", RECORDING, "-o", room, check=True)
    command("calibrate", "targets", "--room", room, "--clips", DATA / "templates", check=True)
    placement = tmp_path / "placement.yaml"
    placement.write_text(PLACEMENT)
    hosts.agent("pc-left", "--media", RECORDING)
    hosts.agent("pc-right", "--media", RECORDING, "--discover")
    alone = tracks_in_one_process(room, tmp_path / "alone")
    assert len(alone.splitlines()) > 60
    assert tracks_on_three_hosts(hosts, room, tmp_path / "three", placement, "--media", RECORDING) == alone
