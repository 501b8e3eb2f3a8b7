"""Real boxes of four cameras that are out of step, against true places of three people."""

from __future__ import annotations

import csv
import json
from collections import defaultdict

import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.plugins.persons.crowded import followed, table

from followspot import Camera, Room
from followspot.messages import Header, stamped
from followspot.people import Boxes
from followspot.points import Points2D
from followspot_accuracy import PoseTruthTable, score_persons

DATA = dataset("people-boxes-cmc1")
AREA = (2.03, 0.0, 6.3, 3.41)
"""Part of the floor that the truth covers, m."""
FPS = 4
pytestmark = needs_data("people-boxes-cmc1")


def room() -> Room:
    cameras = {}
    for one in json.loads((DATA / "cameras.json").read_text())["cameras"]:
        name, size = str(one["camera"]), (one["width"], one["height"])
        K, R, t = (np.array(one[key]) for key in ("K", "R", "t"))
        cameras[name] = Camera(name, "color", size, K, np.zeros(5), R, t)
    return Room("cmc1", cameras=cameras, planes={"floor": np.array([0.0, 0.0, 1.0, 0.0])})


def sets(frames: int) -> list[tuple[tuple[Points2D, Boxes], ...]]:
    rows = defaultdict(list)
    with (DATA / "boxes.csv").open() as file:
        for row in csv.DictReader(file):
            numbers = [float(row[key]) for key in ("x0", "y0", "x1", "y1", "score")]
            rows[int(row["frame"]), row["camera"]].append(numbers)
    found = []
    for frame in range(1, frames + 1):
        each = []
        for camera in "1234":
            numbers = np.array(rows[frame, camera]).reshape(-1, 5)
            none = np.zeros((len(numbers), 0))
            boxes = Boxes(camera, numbers[:, :4].copy(), numbers[:, 4].copy(), none, none)
            header = Header("boxes", frame, frame * 10**9 // FPS)
            each.append((stamped(Points2D.empty(), header), stamped(boxes, header)))
        found.append(tuple(each))
    return found


def truth(frames: int) -> PoseTruthTable:
    pose = np.full((frames, 3, 6), np.nan)
    with (DATA / "truth.csv").open() as file:
        for row in csv.DictReader(file):
            if int(row["frame"]) <= frames:
                pose[int(row["frame"]) - 1, int(row["person"]) - 1, :2] = float(row["x"]), float(row["y"])
    time = np.arange(1, frames + 1) / FPS
    return PoseTruthTable((1, 2, 3), time, pose, np.isfinite(pose[..., 0]).astype(float), np.zeros(2))


@pytest.mark.parametrize(
    ("frames", "mota", "idf1"), [(60, 0.98, 0.985), pytest.param(261, 0.99, 0.99, marks=pytest.mark.thorough)]
)
def test_three_people_are_followed_without_a_switch(frames: int, mota: float, idf1: float) -> None:
    given = sets(frames)
    one = score_persons(table(given, followed(room(), given, "boxes")), truth(frames), AREA).tracking
    assert one.switches == 0
    assert one.mean_m < 0.10
    assert one.idf1 > idf1
    assert one.mota > mota
