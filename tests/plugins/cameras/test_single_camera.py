"""One real camera, real coloured balls: the graph for a single camera finds every throw."""

import csv
from pathlib import Path

import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot import Camera, Room, Target
from followspot.cli.main import main
from followspot.room import StageUse
from followspot.room_file import save

REPOSITORY = Path(__file__).parents[3]
THROWS = dataset("balls-thrown-room")
needs_recordings = needs_data("balls-thrown-room")


def hue(**degrees: float) -> np.ndarray:
    """Histogram of 16 hues from shares like d0=0.4: the share of the hue at 0 degrees."""
    histogram = np.zeros(16)
    for name, share in degrees.items():
        histogram[int(name[1:]) * 16 // 360] += share
    return histogram / histogram.sum()


def office(folder: Path, start: int, frames: int) -> Path:
    """The room of the recording: one uncalibrated camera and the two balls that are thrown."""
    pictures = {"path": str(THROWS.resolve()), "start_frame": start, "frames": frames}
    camera = Camera(
        name="cam0",
        kind="color",
        size=(640, 480),
        matrix=np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]]),
        distortion=np.zeros(5),
        rotation=np.eye(3),
        translation=np.zeros(3),
        source=StageUse("cameras.images", pictures),
    )
    red = Target("red", 0.1, {"cam0": hue(d0=0.42, d340=0.58)}, {"cam0": (500, 1400)})
    yellow = Target("yellow", 0.1, {"cam0": hue(d50=1.0)}, {"cam0": (400, 900)})
    path = folder / "office.yaml"
    save(Room("office", {"cam0": camera}, targets={"red": red, "yellow": yellow}), path)
    return path


@needs_recordings
@pytest.mark.parametrize(
    ("target", "first", "last"), [("red", 158, 266), ("yellow", 540, 632)], ids=["red", "yellow"]
)
def test_throw_is_a_parabola_without_false_blobs(tmp_path: Path, target: str, first: int, last: int) -> None:
    """40 frames around the top, where the wide lens bends the path least; 1 px is the sensor's own noise."""
    start = (first + last) // 2 - 20
    room = office(tmp_path, start, 40)
    graph = str(REPOSITORY / "graphs/single_camera.yaml")
    assert main(["run", graph, "--room", str(room), "--out", str(tmp_path / "run")]) == 0
    with (tmp_path / "run/blobs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["target"] for row in rows} == {target}
    frame = np.array([int(row["frame"]) for row in rows])
    assert frame.tolist() == list(range(start, start + 40))
    for axis in ("u", "v"):
        place = np.array([float(row[axis]) for row in rows])
        residual = place - np.polyval(np.polyfit(frame, place, 2), frame)
        assert np.sqrt(np.mean(residual**2)) < 1.0
