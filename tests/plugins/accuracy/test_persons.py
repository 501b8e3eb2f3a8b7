"""Scores of persons' poses against truth, each on a case small enough to count by hand."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.plugins.accuracy.person_tables import assert_perfect, joined, of, reported, shifted, truth

from followspot.geometry import wrap
from followspot_accuracy import (
    PoseTable,
    persons_table,
    persons_to_json,
    score_persons,
)
from followspot_accuracy.persons.visits import identity_switches


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
