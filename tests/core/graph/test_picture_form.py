"""The source of a camera gives the pictures that the camera's kind promises."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import ROOM

from followspot.errors import InputError
from followspot.graph.compile import compile_graph

SOURCE = "{uses: toy.camera, with: {frames: 20}}"


def compiled(folder: Path, kind: str, uses: str) -> None:
    room = (
        ROOM.split("  cam1:")[0].replace("kind: color", f"kind: {kind}").replace(SOURCE, f"{{uses: {uses}}}")
    )
    (folder / "room.yaml").write_text(room)
    graph = folder / "graph.yaml"
    graph.write_text("graph: g\nroom: room.yaml\nstages: {camera: {uses: room.source, each: cameras}}\n")
    compile_graph(graph)


@pytest.mark.parametrize(
    ("kind", "uses", "gives", "wanted"),
    [
        ("depth", "sim.camera", "Frame", "DepthImage"),
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
    ("kind", "uses"), [("depth", "sim.depth_camera"), ("color", "sim.camera"), ("infrared", "sim.camera")]
)
def test_a_source_that_fits_its_camera_is_none(tmp_path: Path, kind: str, uses: str) -> None:
    compiled(tmp_path, kind, uses)
