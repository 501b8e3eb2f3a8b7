"""The source of a camera gives the pictures that the camera's kind promises."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import ROOM

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan

SOURCE = "{uses: toy.camera, with: {frames: 20}}"


def compiled(folder: Path, kind: str, uses: str, graph: str = "room.source", reader: str = "") -> Plan:
    """The plan of a camera and its source. uses: what the room says; graph: what the graph says."""
    room = (
        ROOM.split("  cam1:")[0].replace("kind: color", f"kind: {kind}").replace(SOURCE, f"{{uses: {uses}}}")
    )
    (folder / "room.yaml").write_text(room)
    file = folder / "graph.yaml"
    camera = f"  camera: {{uses: {graph}, each: cameras}}\n"
    file.write_text(f"graph: g\nroom: room.yaml\nstages:\n{camera}{reader}")
    return compile_graph(file)


@pytest.mark.parametrize(
    ("kind", "uses", "gives", "wanted"),
    [
        ("depth", "sim.marker_camera", "Frame", "DepthImage"),
        ("color", "sim.depth_camera", "DepthImage", "Frame"),
        ("infrared", "sim.depth_camera", "DepthImage", "Frame"),
    ],
)
def test_a_source_of_other_pictures_is_a_mistake_at_its_place(
    tmp_path: Path, kind: str, uses: str, gives: str, wanted: str
) -> None:
    with pytest.raises(InputError) as caught:
        compiled(tmp_path, kind, uses)
    (mistake,) = caught.value.mistakes
    assert mistake.text == f'camera "cam0" is {kind}, and its source {uses} gives {gives}'
    assert wanted in mistake.remedy
    assert mistake.place is not None
    assert (Path(mistake.place.file).name, mistake.place.line) == ("room.yaml", 10)


@pytest.mark.parametrize(
    ("kind", "uses", "source"),
    [
        ("depth", "sim.depth_camera", "sim.depth_camera"),
        ("depth", "sim.camera", "sim.depth_camera"),
        ("color", "sim.camera", "sim.camera"),
        ("infrared", "sim.camera", "sim.camera"),
    ],
)
@pytest.mark.parametrize("graph", ["room.source", ""])
def test_a_source_serves_each_camera_by_its_kind(
    tmp_path: Path, kind: str, uses: str, source: str, graph: str
) -> None:
    """By the room's word or the graph's."""
    plan = compiled(tmp_path, kind, uses, graph or uses)
    assert [stage.uses for stage in plan.stages] == [source]


def test_a_wrong_picture_is_one_mistake_though_it_is_read(tmp_path: Path) -> None:
    reader = "  depth: {uses: balls.depth_blobs, each: cameras, in: {image: camera}}\n"
    with pytest.raises(InputError) as caught:
        compiled(tmp_path, "depth", "sim.marker_camera", reader=reader)
    assert len(caught.value.mistakes) == 1
