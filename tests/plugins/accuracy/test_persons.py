"""Scores of persons' poses against truth, each on a case small enough to count by hand."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.datasets import ROOT, dataset, needs_data

from followspot import InputError, at
from followspot.geometry import wrap
from followspot.people import PoseTruth
from followspot_accuracy import (
    PersonsScore,
    PoseTable,
    PoseTruthTable,
    persons_table,
    persons_to_json,
    pose_truth_of,
    read_pose_truth_csv,
    read_poses_csv,
    score_persons,
)
from followspot_accuracy.persons.visits import identity_switches

PERSONS = dataset("persons-dev")
RENDERED = ROOT / "tests/rendered/people"
RECORDED = ("d_o", "d_p", "d_m_c1")
needs_recordings = needs_data("persons-dev")
FPS = 10.0
HEAD = "frame,time,person,x,y,z_head_top,phi,r,torso_heading,head_pan,head_tilt,confidence"
TRUE_HEAD = "time,person,x,y,z_head_top,r,torso_heading_room,torso_heading,head_pan,head_tilt,visible_upper"


def truth(*places: tuple[float, float], frames: int = 10) -> PoseTruthTable:
    """Persons 1, 2, ... who stand at these places, 1.7 m tall, face the room's x axis and are all visible."""
    pose = np.zeros((frames, len(places), 6))
    pose[..., :2] = np.reshape(places, (-1, 2))
    pose[..., 2] = 1.7
    persons = tuple(range(1, len(places) + 1))
    return PoseTruthTable(persons, np.arange(frames) / FPS, pose, np.ones(pose.shape[:2]), np.zeros(2))


def reported(true: PoseTruthTable, *numbers: int) -> PoseTable:
    """The truth as a tracker would report it, under these numbers."""
    frame, column = np.nonzero(np.isfinite(true.pose[..., 0]))
    person = np.array(numbers or true.persons)[column]
    return PoseTable(true.time[frame], person, true.pose[frame, column])


def shifted(poses: PoseTable, *offset: float) -> PoseTable:
    return replace(poses, pose=poses.pose + offset)


def of(poses: PoseTable, rows: np.ndarray) -> PoseTable:
    return PoseTable(poses.time[rows], poses.person[rows], poses.pose[rows])


def joined(a: PoseTable, b: PoseTable) -> PoseTable:
    return PoseTable(*(np.concatenate([getattr(a, n), getattr(b, n)]) for n in ("time", "person", "pose")))


def assert_perfect(score: PersonsScore) -> None:
    whole = score.overall
    assert whole.coverage == 1.0
    for spread in (whole.direction_deg, whole.distance_m, whole.height_cm, whole.position_cm):
        assert (spread.sigma, spread.p95) == pytest.approx((0, 0), abs=1e-9)
    assert (whole.torso.within_22, whole.torso.flipped) == (1.0, 0.0)
    assert whole.identity_switches == score.surplus.false_rows == score.surplus.duplicate_rows == 0


def test_truth_scored_against_itself_is_perfect() -> None:
    true = truth((2, 0), (0, 3))
    score = score_persons(reported(true), true)
    assert_perfect(score)
    assert list(score.persons) == ["1", "2"]
    assert score.overall.acquire_s == (0.0, 0.0)
    assert score.overall.frames == 20


def test_shift_of_the_place_is_direction_distance_and_position_as_seen_from_the_viewpoint() -> None:
    true = truth((2, 0))
    score = score_persons(shifted(reported(true), 0, 0.2, 0, 0, 0, 0), true).overall
    assert score.direction_deg.mean == pytest.approx(math.degrees(math.atan2(0.2, 2)))
    assert score.distance_m.mean == pytest.approx(math.hypot(2, 0.2) - 2)
    assert score.position_cm.median == pytest.approx(20)
    nearer = score_persons(reported(true), replace(true, viewpoint=np.array([2.0, -1.0]))).overall
    assert nearer.direction_deg.mean == 0


def test_shift_of_height_and_angles_is_told_exactly_and_wraps() -> None:
    true = truth((2, 0))
    offset = [0, 0, -0.05, 2 * np.pi - math.radians(30), math.radians(15), math.radians(-7)]
    score = score_persons(shifted(reported(true), *offset), true).overall
    assert score.height_cm.mean == pytest.approx(-5)
    assert score.height_cm.sigma == pytest.approx(0, abs=1e-9)
    assert score.torso.median_deg == pytest.approx(30)
    assert (score.torso.within_22, score.torso.within_45, score.torso.flipped) == (0, 1, 0)
    assert score.pan_median_deg == pytest.approx(15)
    assert score.tilt_median_deg == pytest.approx(7)


def test_torso_turned_to_the_back_is_flipped() -> None:
    true = truth((2, 0), frames=4)
    poses = reported(true)
    poses.pose[:1, 3] = np.pi
    assert score_persons(poses, true).overall.torso.flipped == 0.25


def test_number_that_changes_is_one_switch_and_two_that_are_exchanged_are_two() -> None:
    alone = truth((2, 0))
    poses = reported(alone)
    poses.person[5:] = 9
    assert score_persons(poses, alone).overall.identity_switches == 1
    both = truth((2, 0), (0, 3))
    poses = reported(both)
    late = poses.time >= 0.5
    poses.person[late] = 3 - poses.person[late]
    score = score_persons(poses, both)
    assert [one.identity_switches for one in score.persons.values()] == [1, 1]
    assert score.overall.identity_switches == 2


def test_number_that_goes_over_to_a_person_who_was_never_tracked_is_a_switch() -> None:
    true = truth((2, 0), (0, 3))
    poses = reported(true, 1, 1)
    second = poses.pose[:, 1] == 3
    poses = of(poses, np.where(poses.time < 0.5, ~second, second))
    score = score_persons(poses, true)
    assert score.persons["2"].identity_switches == 1
    assert score.persons["1"].identity_switches == 0


def test_persons_who_pass_each_other_keep_their_numbers() -> None:
    true = truth((0, 0), (0, 0), frames=21)
    way = np.linspace(-1, 1, 21)
    true.pose[:, 0, 0], true.pose[:, 1, 0] = way, -way
    true.pose[:, 1, 1] = 0.1
    assert_perfect(score_persons(reported(true), true))


def test_pose_far_from_everybody_is_false_and_covers_nobody() -> None:
    true = truth((2, 0))
    score = score_persons(
        joined(reported(true), shifted(of(reported(true), np.arange(3)), 3, 0, 0, 0, 0, 0)), true
    )
    assert (score.surplus.false_rows, score.surplus.false_share) == (3, 0.3)
    assert score.overall.coverage == 1.0
    away = score_persons(shifted(reported(true), 0.7, 0, 0, 0, 0, 0), true)
    assert (away.surplus.false_share, away.overall.coverage) == (1.0, 0.0)
    assert away.overall.distance_m.mean == pytest.approx(0.7)


def test_second_pose_of_a_person_is_a_duplicate_and_no_false_person() -> None:
    true = truth((2, 0))
    near = shifted(replace(reported(true), person=np.full(10, 7)), 0.1, 0, 0, 0, 0, 0)
    score = score_persons(joined(reported(true), near), true)
    assert (score.surplus.false_rows, score.surplus.duplicate_rows) == (0, 10)
    assert score.overall.position_cm.p95 == 0


def test_frames_that_show_less_than_half_of_a_person_are_not_measured() -> None:
    true = truth((2, 0))
    true.visible[:4] = 0.4
    poses = reported(true)
    poses.pose[:4, 2] += 1
    score = score_persons(poses, true).overall
    assert (score.frames, score.height_cm.p95, score.coverage) == (6, 0, 1.0)


def test_coming_late_and_staying_too_long_are_told_in_seconds() -> None:
    true = truth((2, 0), frames=20)
    true.visible[10:] = 0
    poses = of(reported(true), np.arange(3, 14))
    score = score_persons(poses, true).overall
    assert score.acquire_s == pytest.approx((0.3,))
    assert score.vanish_s == pytest.approx((0.4,))
    never = score_persons(of(poses, np.zeros(0, int)), true).overall
    assert (never.acquire_s, never.vanish_s) == (pytest.approx((1.0,)), ())


def test_person_who_returns_is_known_by_the_same_number_or_not() -> None:
    true = truth((2, 0), frames=30)
    true.visible[10:20] = 0
    poses = of(reported(true), np.r_[:10, 20:30])
    known = score_persons(poses, true).overall
    assert (known.returns, known.returns_known, known.identity_switches) == (1, 1, 0)
    poses.person[10:] = 2
    new = score_persons(poses, true).overall
    assert (new.returns, new.returns_known, new.identity_switches) == (1, 0, 1)
    assert all(type(count) is int for one in (known, new) for count in (one.returns, one.returns_known))


def test_pose_that_stays_until_the_person_returns_stays_as_long_as_the_person_is_away() -> None:
    true = truth((2, 0), frames=50)
    true.visible[10:20] = true.visible[30:45] = 0
    score = score_persons(reported(true), true).overall
    assert score.acquire_s == (0.0, 0.0, 0.0)
    assert score.vanish_s == pytest.approx((1.0, 1.5))
    assert (score.returns, score.returns_known) == (2, 2)


def test_what_lasts_until_the_recording_ends_lasts_to_the_end_of_its_last_frame() -> None:
    true = truth((2, 0), frames=20)
    never = score_persons(of(reported(true), np.zeros(0, int)), true).overall
    assert never.acquire_s == pytest.approx((2.0,))
    true.visible[10:] = 0
    assert score_persons(reported(true), true).overall.vanish_s == pytest.approx((1.0,))
    one = truth((2, 0), frames=1)
    assert score_persons(reported(one), one).overall.acquire_s == (0.0,)


def test_poses_between_frames_go_to_the_nearest_and_one_of_a_number_counts() -> None:
    true = truth((2, 0))
    twice = replace(reported(true), time=true.time + 0.02)
    score = score_persons(joined(reported(true), shifted(twice, 0, 0, 1, 0, 0, 0)), true)
    assert score.overall.height_cm.p95 == 0
    assert score.surplus.duplicate_rows == 0
    late = score_persons(replace(reported(true), time=true.time + 100), true)
    assert (late.overall.coverage, late.surplus.false_rows) == (0, 0)


def test_nothing_reported_and_nobody_there_have_scores_without_numbers() -> None:
    none = PoseTable(np.zeros(0), np.zeros(0, int), np.zeros((0, 6)))
    score = score_persons(none, truth((2, 0)))
    assert score.overall.coverage == 0
    assert math.isnan(score.overall.height_cm.sigma)
    assert "null" in json.dumps(persons_to_json(score), allow_nan=False)
    empty = score_persons(reported(truth((2, 0))), truth())
    assert empty.surplus.false_rows == 10
    assert "false persons: 10" in persons_table(empty)
    assert "NaN" not in json.dumps(persons_to_json(score_persons(none, truth(frames=0))))


@given(
    offset=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-0.3, 0.3)),
    turn=st.floats(-20, 20),
)
def test_any_shift_within_reach_comes_back_as_it_is(offset: tuple[float, ...], turn: float) -> None:
    true = truth((2, 1), (-2, 1))
    score = score_persons(shifted(reported(true), *offset, turn, 0, 0), true).overall
    assert score.position_cm.median == pytest.approx(100 * math.hypot(*offset[:2]), abs=1e-6)
    assert score.height_cm.mean == pytest.approx(100 * offset[2], abs=1e-6)
    assert score.torso.median_deg == pytest.approx(abs(math.degrees(wrap(np.array(turn)))), abs=1e-6)


def test_switches_count_new_numbers_and_stolen_ones() -> None:
    identity = np.array([[1, -1], [-1, -1], [1, 2], [2, 1], [2, -1], [2, 1], [3, 2]])
    assert identity_switches(identity).tolist() == [2, 2]


def test_table_has_a_column_per_person_and_one_for_all() -> None:
    true = truth((2, 0), (0, 3))
    lines = persons_table(score_persons(reported(true), true)).splitlines()
    assert lines[0].split() == ["person", "1", "2", "all"]
    assert persons_table(score_persons(reported(truth((2, 0))), truth((2, 0)))).split()[:2] == ["person", "1"]


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
