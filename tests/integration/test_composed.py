"""Two instances of a sub-graph and the same graph written out give the same bytes, in any placement."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.integration.running import COMMAND

GRAPHS = Path(__file__).parents[2] / "graphs"
BUILDING = f"""\
graph: building
room: {GRAPHS}/rooms/simulated.yaml
stages:
  camera: {{uses: room.source, each: cameras}}
  hall:
    graph: {GRAPHS}/glowballs.yaml
    cameras: "cameras[name=cam0|cam1|cam2]"
    with: {{tracks_file: hall.csv}}
  stage:
    graph: {GRAPHS}/glowballs.yaml
    cameras: "cameras[name=cam0|cam3|cam4|cam5]"
    in: {{frames: camera}}
    with: {{tracks_file: stage.csv, similarity: 0.8}}
"""
FRAMES = "24"


def tracks(graph: Path, out: Path, *options: str) -> list[bytes]:
    """The files that both instances write."""
    words = ["run", str(graph), "--frames", FRAMES, "--out", str(out), "--quiet", *options]
    subprocess.run([*COMMAND, *words], check=True, timeout=300)
    return [(out / name).read_bytes() for name in ("hall.csv", "stage.csv")]


def test_sub_graphs_and_the_flat_graph_give_the_same_bytes(tmp_path: Path) -> None:
    nested, flat = tmp_path / "building.yaml", tmp_path / "flat.yaml"
    nested.write_text(BUILDING)
    flat.write_bytes(subprocess.check_output([*COMMAND, "graph", str(nested), "--flat"]))
    found = tracks(nested, tmp_path / "nested")
    assert all(text.count(b"\n") > int(FRAMES) for text in found), "balls are tracked in both"
    assert found[0] != found[1]
    assert tracks(flat, tmp_path / "flat") == found
    assert tracks(nested, tmp_path / "apart", "--placement", "camera") == found
