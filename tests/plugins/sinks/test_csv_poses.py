"""Poses of persons as a CSV file."""

from pathlib import Path

import numpy as np
from tests.datasets import dataset, needs_data

from followspot import Camera, Context, Header, Room
from followspot.messages import stamped
from followspot.people import Poses, as_seen
from followspot.testing import check_stage
from followspot_accuracy import read_pose_truth_csv, read_poses_csv
from followspot_sinks.csv_file import CsvFile

PERSONS = dataset("persons-dev")
needs_recordings = needs_data("persons-dev")
AT = np.array([1.0, 1.0, 1.2])
ALONG_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation of a level camera that looks along the room's y axis."""


def camera(rotation: np.ndarray = ALONG_Y, center: np.ndarray = AT) -> Camera:
    K = np.array([[400.0, 0, 160], [0, 400, 120], [0, 0, 1]])
    return Camera("left", "color", (320, 240), K, np.zeros(5), rotation, -rotation @ center)


def poses(seen_by: str, xy: list[list[float]], heading: list[float]) -> Poses:
    rows = len(xy)
    message = Poses(
        camera=seen_by,
        person=np.arange(1, rows + 1, dtype="i4"),
        state=np.ones(rows, "u1"),
        xy=np.array(xy).reshape(-1, 2),
        height=np.full(rows, 1.75),
        heading=np.array(heading),
        pan=np.full(rows, 0.5),
        tilt=np.full(rows, -0.25),
        sigma=np.zeros((rows, 6)),
        confidence=np.full(rows, 0.875),
    )
    return stamped(message, Header("pose", 7, 233_333_333))


def saved(folder: Path, *messages: Poses) -> Path:
    sink = CsvFile(Context(room=Room(cameras={"left": camera()}), out=folder), path="poses.csv")
    sink.setup()
    for message in messages:
        sink.process((message,))
    sink.close()
    return folder / "poses.csv"


def test_stage_keeps_the_promises_of_stages() -> None:
    check_stage(CsvFile)


def test_pose_is_told_as_its_camera_sees_it(tmp_path: Path) -> None:
    lines = saved(tmp_path, poses("left", [[1, 3], [0, 2]], [-np.pi / 2, 0])).read_text().splitlines()
    assert lines == [
        "frame,time,person,x,y,z_head_top,phi,r,torso_heading,head_pan,head_tilt,confidence,camera",
        "7,0.233333333,1,1.0000,3.0000,1.7500,0.0000,2.0000,0.0000,0.5000,-0.2500,0.8750,left",
        "7,0.233333333,2,0.0000,2.0000,1.7500,0.7854,1.4142,0.7854,0.5000,-0.2500,0.8750,left",
    ]


def test_fused_pose_is_told_in_the_room(tmp_path: Path) -> None:
    line = saved(tmp_path, poses("", [[0, 2]], [3.0])).read_text().splitlines()[1]
    assert line == "7,0.233333333,1,0.0000,2.0000,1.7500,1.5708,2.0000,3.0000,0.5000,-0.2500,0.8750,"


def test_frame_without_persons_has_no_row(tmp_path: Path) -> None:
    assert len(saved(tmp_path, poses("left", [], [])).read_text().splitlines()) == 1


def test_saved_poses_read_back(tmp_path: Path) -> None:
    path = saved(tmp_path, poses("left", [[1, 3], [0, 2]], [2.0, -3.0]), poses("", [[0, 2]], [3.0]))
    table = read_poses_csv(path, lambda _: AT[:2])
    np.testing.assert_allclose(table.pose[:, :2], [[1, 3], [0, 2], [0, 2]], atol=1e-4)
    np.testing.assert_allclose(table.pose[:, 3], [2, -3, 3], atol=1e-3)


@needs_recordings
def test_recorded_directions_distances_and_headings_are_met() -> None:
    """A camera as the recordings describe it, with what its truth says of the first frame."""
    yaw = -0.8028514559173915
    forward = [np.cos(yaw), np.sin(yaw), 0]
    rotation = np.array([[forward[1], -forward[0], 0], [0, 0, -1], forward])
    seen = camera(rotation, np.array([-2.1, 2.1, 1.3]))
    truth = read_pose_truth_csv(PERSONS / "d_m_c1_gt.csv")
    phi, r, torso = as_seen(seen, truth.pose[0, :, :2], truth.pose[0, :, 3])
    np.testing.assert_allclose(phi, [0.3932, -0.0139], atol=2e-4)
    np.testing.assert_allclose(r, [3.2708, 2.1935], atol=2e-4)
    np.testing.assert_allclose(torso, [1.7891, -2.8443], atol=2e-4)
