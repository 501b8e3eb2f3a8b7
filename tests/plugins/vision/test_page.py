"""The graphs of docs/other_programs.md run on files of the kind that they name."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.vision.made_points import ROOT, simulated, truth_of

from followspot import Room
from followspot.cli.main import main
from followspot.geometry import project
from followspot_vision.skeletons import COCO

FRAMES = 12
PAGE = (ROOT / "docs/other_programs.md").read_text(encoding="utf-8")
GRAPHS = {
    found[1]: found[0] for found in re.findall(r"^```yaml\n(graph: (\w+)\n.*?)^```$", PAGE, re.S | re.M)
}


def write_boxes(folder: Path, room: Room, truth: list[Mapping[str, np.ndarray]]) -> None:
    lines = ["frame,camera,bb_left,bb_top,bb_width,bb_height,conf,label"]
    for frame, there in enumerate(truth):
        for camera in room.cameras.values():
            for label, place in there.items():
                x, y = project(camera, place[None])[0] + 0.5
                lines.append(f"{frame},{camera.name},{x - 4},{y - 3},8,6,0.9,{label}")
    (folder / "boxes.csv").write_text("\n".join(lines))


def write_persons(folder: Path, room: Room, truth: list[Mapping[str, np.ndarray]]) -> None:
    (folder / "persons.csv").write_text("frame,camera,x0,y0,x1,y1,label\n")


def write_keypoints(folder: Path, room: Room, truth: list[Mapping[str, np.ndarray]]) -> None:
    """A body whose joints are all at the green ball."""
    (folder / "keypoints").mkdir()
    for camera in room.cameras.values():
        places = [project(camera, there["green"][None])[0] for there in truth]
        results = [
            {"image_id": frame, "keypoints": [float(x), float(y), 0.9] * len(COCO), "score": 1}
            for frame, (x, y) in enumerate(places)
        ]
        (folder / f"keypoints/{camera.name}.json").write_text(json.dumps(results))


def write_mocap(folder: Path, room: Room, truth: list[Mapping[str, np.ndarray]]) -> None:
    lines = ["frame,x,y,z,label"]
    for frame, there in enumerate(truth):
        for label, (x, y, z) in there.items():
            lines.append(f"{frame},{1000 * x},{1000 * (z - 0.1)},{-1000 * y},{label}")
    (folder / "mocap.csv").write_text("\n".join(lines))


WRITERS = {
    "boxes": write_boxes,
    "persons_of_another_detector": write_persons,
    "joints": write_keypoints,
    "mocap": write_mocap,
}


def test_every_graph_of_the_page_is_tried() -> None:
    assert GRAPHS.keys() == WRITERS.keys()


@pytest.mark.parametrize("name", WRITERS)
def test_the_graphs_of_the_page_find_what_is_in_the_files(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graphs").symlink_to(ROOT / "graphs")
    (tmp_path / "graph.yaml").write_text(GRAPHS[name])
    room = simulated()
    truth = list(truth_of(room, FRAMES))
    WRITERS[name](tmp_path, room, truth)
    if name == "persons_of_another_detector":
        assert main(["check", "graph.yaml"]) == 0
        return
    assert main(["run", "graph.yaml", "--out", "out", "--quiet"]) == 0
    file, named = ("joints.csv", "label") if name == "joints" else ("tracks.csv", "object")
    with (tmp_path / "out" / file).open(newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if row["frame"] == str(FRAMES - 1)]
    last = {row[named]: [float(row[axis]) for axis in "xyz"] for row in rows}
    expected = dict.fromkeys(COCO, truth[-1]["green"]) if name == "joints" else truth[-1]
    assert last.keys() == expected.keys()
    for label, place in expected.items():
        np.testing.assert_allclose(last[label], place, atol=0.02)
