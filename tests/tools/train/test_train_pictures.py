"""`followspot train hog` from end to end on a part of the pictures of the shipped weights."""

import csv
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot import Camera
from followspot.cli.main import main
from followspot.context import Context
from followspot.tracking import Frame
from followspot_persons.hog.model import load
from followspot_persons.hog.search import overlap
from followspot_persons.hog.stage import Hog
from followspot_train import boosting, linear, recipe

ROOMS, STREETS = dataset("persons-dev") / "hog", dataset("person-crops-inria")
SMALLER = (
    (linear, "FIRST", 1500),
    (linear, "HARD", 500),
    (recipe, "DECEIVING", 60),
    (recipe, "VIEWS", 6),
    (boosting, "TREES", 100),
)


def copied(folder: Path, files: list[Path]) -> None:
    folder.mkdir(parents=True)
    for file in files:
        shutil.copy(file, folder)


@pytest.fixture
def folders(tmp_path: Path) -> list[Path]:
    """Every eighth crop of the rooms, every tenth of the streets, a quarter of the streets without people."""
    with (ROOMS / "boxes.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))[::8]
    rooms, streets = tmp_path / "rooms", tmp_path / "streets"
    copied(rooms, [*(ROOMS / row["file"] for row in rows), *ROOMS.glob("neg_*")])
    with (rooms / "boxes.csv").open("w", newline="") as stream:
        table = csv.DictWriter(stream, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    for part, step in (("pos", 10), ("neg", 4)):
        copied(streets / part, sorted((STREETS / part).iterdir())[::step])
    return [rooms, streets]


@pytest.mark.thorough
@needs_data("persons-dev", "person-crops-inria")
def test_a_user_learns_network_trees_and_calibration_that_find_a_stranger(
    folders: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module, name, value in SMALLER:
        monkeypatch.setattr(module, name, value)
    rooms, streets = map(str, folders)
    out = folders[0].parent / "weights.npz"
    assert main(["train", "hog", rooms, streets, "-o", str(out), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["found"][streets]["persons"] == 67  # each once, by a model that did not know it
    assert report["found"][rooms]["recall"] > 0.7
    assert report["found"][streets]["recall"] > 0.25
    model = load(out)
    assert len(model.tree_leaf) == 100
    assert model.calibration[0] > 1.0  # the mean of two log-odds is softer than the log-odds
    assert found(out) >= 4


def found(weights: Path) -> int:
    """Number of five pictures of `d_p`, whose person was not learnt from, in which the best box is right."""
    matrix = np.array([[457.0, 0, 319.5], [0, 457.0, 239.5], [0, 0, 1]])
    facing = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
    camera = Camera("c", "color", (640, 480), matrix, np.zeros(5), facing, -facing @ [0, 0, 1.2])
    stage = Hog(Context.serving(camera), weights=str(weights), minimum_score=-1.0)
    stage.setup()
    with (dataset("persons-dev") / "d_p_gt.csv").open(newline="") as stream:
        truth = {int(row["frame"]): row for row in csv.DictReader(stream)}
    video, hits = cv2.VideoCapture(str(dataset("persons-dev") / "d_p.mp4")), 0
    for number in range(0, 200, 40):
        video.set(cv2.CAP_PROP_POS_FRAMES, number)
        boxes = stage.process(Frame(camera="c", pixels=np.asarray(video.read()[1])))
        assert boxes is not None
        true = np.array([float(truth[number][c]) for c in ("ux0", "uy0", "ux1", "uy1")])
        hits += len(boxes.box) > 0 and bool(overlap(true, boxes.box[:1], 0.0)[0] > 0.4)
    return hits
