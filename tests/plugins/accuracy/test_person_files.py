"""Poses and truth of persons as they are read from files and messages."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.datasets import ROOT, dataset, needs_data
from tests.plugins.accuracy.person_tables import assert_perfect

from followspot import InputError, at
from followspot.people import PoseTruth
from followspot_accuracy import (
    pose_truth_of,
    read_pose_truth_csv,
    read_poses_csv,
    score_persons,
)

PERSONS = dataset("persons-dev")
RENDERED = ROOT / "tests/rendered/people"
RECORDED = ("d_o", "d_p", "d_m_c1")
needs_recordings = needs_data("persons-dev")
HEAD = "frame,time,person,x,y,z_head_top,phi,r,torso_heading,head_pan,head_tilt,confidence"
TRUE_HEAD = "time,person,x,y,z_head_top,r,torso_heading_room,torso_heading,head_pan,head_tilt,visible_upper"


def test_relative_headings_become_those_of_the_room_and_fused_ones_are(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(
        f"{HEAD},camera\n0,0.0,4,2,0,1.7,0,2,0.5,0.1,0.2,1,left\n0,0.0,5,2,0,1.7,0,2,0.5,0,0,1,\n"
    )
    poses = read_poses_csv(path, lambda name: {"left": np.zeros(2)}[name])
    assert poses.person.tolist() == [4, 5]
    np.testing.assert_allclose(poses.pose[0], [2, 0, 1.7, 0.5 - np.pi, 0.1, 0.2])
    np.testing.assert_allclose(poses.pose[1, 3], 0.5)


def test_poses_without_a_camera_column_are_relative_to_the_camera(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(f"{HEAD}\n0,0.0,4,0,2,1.7,0,2,0,0,0,1\n")
    assert read_poses_csv(path, lambda _: np.zeros(2)).pose[0, 3] == pytest.approx(-np.pi / 2)


@pytest.mark.parametrize(
    ("row", "complaint"),
    [
        ("0,0.0,1.5,2,0,1.7,0,2,0,0,0,1", r"poses\.csv:2:7: \"1\.5\" in column person"),
        ("0,0.0,-1,2,0,1.7,0,2,0,0,0,1", "a whole number from 0"),
        ("0,0.0,1,2,inf,1.7,0,2,0,0,0,1", "a finite number"),
        ("0,0.0,1,2", "4 columns, 11 needed"),
    ],
)
def test_bad_row_of_poses_is_named(tmp_path: Path, row: str, complaint: str) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(f"{HEAD}\n{row}\n")
    with pytest.raises(InputError, match=complaint):
        read_poses_csv(path, lambda _: np.zeros(2))


def test_truth_of_several_cameras_is_united_by_person_and_the_best_view_counts(tmp_path: Path) -> None:
    left, right = tmp_path / "left.csv", tmp_path / "right.csv"
    left.write_text(f"{TRUE_HEAD}\n0,1,1,0,1.7,1,0.5,0,0,0,0.2\n0,2,3,0,1.6,1,0.5,0,0,0,0.9\n")
    right.write_text(f"{TRUE_HEAD}\n0,1,1,0,1.7,2,0.5,1,0,0,0.8\n1,1,1,0,1.7,2,0.5,1,0,0,1\n")
    both = read_pose_truth_csv(left, right)
    assert both.persons == (1, 2)
    assert both.visible.tolist() == [[0.8, 0.9], [1.0, 0.0]]
    assert np.isnan(both.pose[1, 1]).all()
    assert both.viewpoint.tolist() == [0, 0]
    np.testing.assert_allclose(
        read_pose_truth_csv(left).viewpoint,
        [2 + math.cos(0.5), math.sin(0.5)],
    )


@pytest.mark.parametrize(
    "text",
    [
        f"{TRUE_HEAD}\n0,1,1,0,1.7,1,0.5,0,0,0,0.2\n0.00004,1,1,0,1.7,1,0.5,0,0,0,0.2\n",
        "time,person,x,y\n0,1,1.5,0\n0,1,1.6,0\n",
    ],
)
def test_a_second_row_of_a_person_in_a_frame_of_one_file_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "truth.csv"
    path.write_text(text)
    with pytest.raises(
        InputError, match=r'truth\.csv:3:1: person "1" has a row of this frame already, in li'
    ):
        read_pose_truth_csv(path)


def test_poses_with_two_rows_of_a_person_at_one_time_are_refused(tmp_path: Path) -> None:
    """The rows of different cameras are different views of one person."""
    path = tmp_path / "poses.csv"
    head = "time,person,x,y,z_head_top,torso_heading,head_pan,head_tilt,camera"
    rows = ["0,1,1,0,1.7,1,0,0,a", "0,1,1,0,1.7,1,0,0,b", "0,1,1,0,1.7,1,0,0,"]
    path.write_text("\n".join([head, *rows]))
    assert len(read_poses_csv(path, lambda name: np.zeros(2)).time) == 3
    path.write_text("\n".join([head, *rows, rows[1]]))
    told = r'poses\.csv:5:1: person "1" has a row of this frame already, in line 3'
    with pytest.raises(InputError, match=told):
        read_poses_csv(path, lambda name: np.zeros(2))


@pytest.mark.parametrize("first", [0, 1, 2])
def test_of_several_views_of_a_person_the_most_visible_pose_counts(tmp_path: Path, first: int) -> None:
    files = [tmp_path / name for name in ("far.csv", "near.csv", "place.csv")]
    files[0].write_text(f"{TRUE_HEAD}\n0,1,1,0,1.6,1,0.5,0,0,0,0.2\n")
    files[1].write_text(f"{TRUE_HEAD}\n0,1,1,0,1.7,2,0.5,1,0,0,0.8\n")
    files[2].write_text("time,person,x,y\n0,1,1.5,0\n")
    both = read_pose_truth_csv(*files[first:], *files[:first])
    assert both.pose[0, 0, [0, 2]].tolist() == [1.0, 1.7]
    assert both.visible.tolist() == [[1.0]]


def test_messages_become_a_table() -> None:
    message = PoseTruth(
        person=np.array([3], "i4"),
        xy=np.array([[1.0, 2.0]]),
        height=np.array([1.8]),
        heading=np.array([0.1]),
        pan=np.array([0.2]),
        tilt=np.array([0.3]),
        visible=np.array([0.7]),
    )
    table = pose_truth_of([at(2_000_000_000, message)])
    assert (table.persons, table.time.tolist(), table.visible.tolist()) == ((3,), [2.0], [[0.7]])
    np.testing.assert_array_equal(table.pose[0, 0], [1, 2, 1.8, 0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    "path",
    [
        RENDERED / "left_gt.csv",
        *(pytest.param(PERSONS / f"{name}_gt.csv", marks=needs_recordings) for name in RECORDED),
    ],
)
def test_recorded_truth_scored_against_itself_is_perfect(path: Path) -> None:
    true = read_pose_truth_csv(path)
    poses = read_poses_csv(path, lambda _: true.viewpoint)
    score = score_persons(poses, true)
    assert score.overall.torso.median_deg < 0.02
    assert_perfect(score)


@needs_recordings
@pytest.mark.parametrize(
    ("name", "place"), [("d_p", (0, 0)), ("d_m_c1", (-2.1, 2.1)), ("d_m_c2", (1.78, 1.98))]
)
def test_place_of_the_camera_follows_from_its_truth(name: str, place: tuple[float, float]) -> None:
    np.testing.assert_allclose(read_pose_truth_csv(PERSONS / f"{name}_gt.csv").viewpoint, place, atol=2e-4)


def test_truth_of_persons_without_rows_is_a_mistake(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("frame,time,person,x,y,height,heading,pan,tilt,visible\n")
    with pytest.raises(InputError, match=r"truth\.csv has no rows: there is nothing to score by"):
        read_pose_truth_csv(path)
