"""Two instances of a sub-graph and the same graph written out give the same bytes, in any placement."""

from __future__ import annotations

from pathlib import Path

from tests.commands import command

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
    command("run", graph, "--frames", FRAMES, "--out", out, "--quiet", *options, check=True)
    return [(out / name).read_bytes() for name in ("hall.csv", "stage.csv")]


def test_sub_graphs_and_the_flat_graph_give_the_same_bytes(tmp_path: Path) -> None:
    nested, flat = tmp_path / "building.yaml", tmp_path / "flat.yaml"
    nested.write_text(BUILDING)
    flat.write_text(command("graph", nested, "--flat").stdout)
    found = tracks(nested, tmp_path / "nested")
    assert all(text.count(b"\n") > int(FRAMES) for text in found), "balls are tracked in both"
    assert found[0] != found[1]
    assert tracks(flat, tmp_path / "flat") == found
    assert tracks(nested, tmp_path / "apart", "--placement", "camera") == found
