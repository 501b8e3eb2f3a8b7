"""A source that ends before others of its kind is named."""

from __future__ import annotations

from pathlib import Path

import pytest

import followspot as fs

STAGES = Path(__file__).parents[2] / "stages/ends.py"
GRAPH = """
graph: ends
room: room.yaml
stages:
  camera: {uses: room.source, each: cameras}
  pass: {uses: ends.pass, each: cameras, in: {frame: camera, other: {from: first, delay: 1}}}
  first: {uses: ends.first, in: {frames: pass}}
"""
CAMERA = """  c{number}:
    kind: color
    size: [6, 4]
    matrix: [[6, 0, 2.5], [0, 6, 1.5], [0, 0, 1]]
    rotation: [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    translation: [{number}, 1, 3]
    source: {{uses: ends.camera, with: {{count: {count}}}}}
"""


def told(
    folder: Path, counts: tuple[int, ...], placement: str | None = None, frames: int | None = None
) -> list[str]:
    """The warnings of a run whose cameras have these numbers of frames, ten a second."""
    (folder / "graph.yaml").write_text(GRAPH)
    cameras = (CAMERA.format(number=number, count=count) for number, count in enumerate(counts))
    (folder / "room.yaml").write_text("room: ends\ncameras:\n" + "".join(cameras))
    graph, out = folder / "graph.yaml", folder / "out"
    with fs.run(graph, plugin_files=[STAGES], out=out, placement=placement, frames=frames) as run:
        return list(run.wait().warnings)


@pytest.mark.parametrize("placement", [None, "camera"])
def test_a_camera_whose_recording_ends_a_second_early_is_named(tmp_path: Path, placement: str | None) -> None:
    """It is the only news: that messages for its stages find no partner from then on follows from it."""
    with pytest.warns(UserWarning, match="camera/c1 ended"):
        assert told(tmp_path, (30, 12, 28), placement=placement) == [
            "camera/c1 ended after 12 messages, 1.80 s before camera/c0: its recording is cut off, or has no "
            "entries where nothing was seen"
        ]


@pytest.mark.filterwarnings("ignore:.*found no partner")
def test_cameras_that_end_within_a_second_of_each_other_are_not(tmp_path: Path) -> None:
    assert not any("ended" in text for text in told(tmp_path, (30, 21, 28)))


def test_cameras_that_a_limit_ends_are_not(tmp_path: Path) -> None:
    assert told(tmp_path, (30, 12, 28), frames=10) == []
