"""Scores of tracks against truth, each on a case small enough to count by hand."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.plugins.accuracy.target_tables import FPS, only, still, truth

from followspot import Camera, Room, at
from followspot.rotation import from_rotation_vector
from followspot.tracking import MISSING, PREDICTED, TRACKED, Truth
from followspot_accuracy import (
    TrackTable,
    score,
    table,
    to_json,
    truth_of,
)
from followspot_accuracy.statistics import nearest
from followspot_accuracy.targets.metrics import PAPER_UNIT, found_while_sought, jerk_cost, recoveries


def tracks(xyz: np.ndarray, state: int = TRACKED, shift: float = 0.0) -> TrackTable:
    """Rows for objects a, b, ... at (F, M, 3) m; NaN: no row."""
    frame, target = np.nonzero(np.isfinite(xyz[..., 0]))
    states = np.full(len(frame), state, "u1")
    return TrackTable(
        tuple("abcdef"[: xyz.shape[1]]), frame / FPS + shift, target, states, xyz[frame, target]
    )


def test_perfect_tracks_have_no_fault() -> None:
    xyz = still(20, (1, 2, 3), (2, 2, 2))
    for one in score(tracks(xyz), truth(xyz)).values():
        assert (one.frames, one.coverage, one.rmse_mm, one.identity_switches) == (20, 1.0, 0.0, 0)
        assert one.recovery_frames == ()
        assert math.isnan(one.false_share)


def test_errors_are_over_trackable_frames_with_a_row_and_keep_outliers() -> None:
    xyz = still(10, (0, 0, 0))
    estimate = xyz.copy()
    estimate[:4, 0, 0] = 0.003
    estimate[4:8, 0, 1] = 0.004
    estimate[8, 0, 2] = 1.0
    estimate[9] = np.nan
    one = only(score(tracks(estimate), truth(xyz)))
    assert one.coverage == pytest.approx(0.8)
    assert one.median_mm == pytest.approx(4.0)
    assert one.rmse_mm == pytest.approx(math.sqrt((4 * 9 + 4 * 16 + 1e6) / 9))
    assert one.p95_mm == pytest.approx(np.percentile([3] * 4 + [4] * 4 + [1000], 95))


def test_frames_that_are_not_trackable_do_not_count() -> None:
    xyz = still(10, (0, 0, 0))
    estimate = xyz.copy()
    estimate[5:] = np.nan
    visible = np.arange(10)[:, None] < 5
    one = only(score(tracks(estimate), truth(xyz, trackable=visible)))
    assert (one.frames, one.coverage) == (5, 1.0)


@given(st.floats(-0.49, 0.49))
def test_rows_match_the_nearest_frame_within_half_an_interval(shift: float) -> None:
    xyz = still(10, (0, 0, 0)) + np.arange(10)[:, None, None]
    one = only(score(tracks(xyz, shift=shift / FPS), truth(xyz)))
    assert (one.coverage, one.rmse_mm) == (1.0, 0.0)


def test_of_several_rows_the_one_nearest_in_time_counts() -> None:
    """A tracker at six times the rate of the truth, that is right in each of its frames."""
    fast, every = 120, 6
    moving = np.zeros((fast, 1, 3))
    moving[:, 0, 0] = np.linspace(0, 2, fast)
    rows = TrackTable(
        ("a",), np.arange(fast) / FPS / every, np.zeros(fast, int), np.full(fast, TRACKED, "u1"), moving[:, 0]
    )
    one = only(score(rows, truth(moving[::every])))
    assert (one.coverage, one.rmse_mm) == (1.0, 0.0)


def test_the_only_frame_is_matched_whenever_its_row_comes() -> None:
    xyz = still(1, (1, 2, 3))
    one = only(score(tracks(xyz, shift=5.0), truth(xyz)))
    assert (one.frames, one.coverage, one.rmse_mm) == (1, 1.0, 0.0)


def test_rows_outside_the_recording_match_nothing() -> None:
    xyz = still(3, (0, 0, 0))
    assert only(score(tracks(xyz, shift=1.0), truth(xyz))).coverage == 0


@given(st.lists(st.floats(-5, 15), min_size=1, max_size=20))
def test_nearest_is_the_nearest(values: list[float]) -> None:
    grid = np.arange(10.0)
    index, distance = nearest(grid, np.array(values))
    expected = np.abs(grid[None] - np.array(values)[:, None]).min(axis=1)
    np.testing.assert_allclose(distance, expected)
    np.testing.assert_allclose(np.abs(grid[index] - values), expected)


def test_switch_is_counted_when_the_position_goes_to_the_other_object() -> None:
    xyz = still(12, (0, 0, 0), (1, 0, 0))
    estimate = xyz.copy()
    estimate[3:6, 0] = xyz[3:6, 1]
    estimate[6, 0] = np.nan  # a gap within the switched stretch is not a second switch
    estimate[7, 0] = xyz[7, 1]
    estimate[10:, 0] = xyz[10:, 1]
    scores = score(tracks(estimate), truth(xyz))
    assert scores["a"].identity_switches == 2
    assert scores["b"].identity_switches == 0


def test_objects_that_touch_are_no_switch() -> None:
    xyz = still(5, (0, 0, 0), (0.1, 0, 0))
    assert score(tracks(xyz), truth(xyz))["a"].identity_switches == 0


def test_false_positions_are_tracked_rows_while_hidden() -> None:
    xyz = still(10, (0, 0, 0))
    gone = np.arange(10)[:, None] >= 6
    estimate = xyz.copy()
    estimate[8:] = np.nan
    flags = {"hidden": gone, "trackable": ~gone, "pair": ~gone}
    one = only(score(tracks(estimate), truth(xyz, **flags)))
    assert (one.hidden_frames, one.false_positions, one.false_share) == (4, 2, 0.5)
    assert only(score(tracks(estimate, MISSING), truth(xyz, **flags))).false_positions == 0


def test_beyond_is_the_share_of_trackable_frames_that_are_reported_elsewhere() -> None:
    xyz = still(10, (0, 0, 0))
    estimate = xyz.copy()
    estimate[2:5, 0, 2] = 0.2
    estimate[5] = np.nan
    seen = np.arange(10)[:, None] >= 4
    one = only(score(tracks(estimate), truth(xyz, trackable=seen, pair=seen)))
    assert (one.frames, one.beyond, one.coverage) == (6, 1 / 6, 4 / 6)


def test_target_that_is_not_in_the_room_is_hidden_everywhere() -> None:
    scores = score(tracks(still(4, (0, 0, 0), (1, 1, 1))), truth(still(4, (0, 0, 0))))
    assert (scores["b"].frames, scores["b"].false_positions, scores["b"].false_share) == (0, 4, 1.0)


def bits(text: str) -> np.ndarray:
    return np.array([c == "1" for c in text])


@pytest.mark.parametrize(
    ("trackable", "hidden", "pair", "right", "delays"),
    [
        ("1111", "0000", "1111", "1111", ()),
        ("1001111", "0110000", "1000111", "1000011", (1,)),
        ("1001111", "0110000", "1001111", "1001111", (0,)),
        ("1001111", "0110000", "1001111", "1000000", (4,)),
        ("1001100", "0110011", "1001100", "1000000", (2,)),
        ("1011011", "0100000", "1011011", "1000001", (4,)),
        ("0111", "0000", "0111", "0011", (1,)),
    ],
    ids=["never away", "late", "at once", "never", "hidden again", "flicker on return", "from the start"],
)
def test_recovery_counts_from_the_pair_of_views_to_the_first_right_position(
    trackable: str, hidden: str, pair: str, right: str, delays: tuple[int, ...]
) -> None:
    assert recoveries(bits(trackable), bits(hidden), bits(pair), bits(right)) == delays


@pytest.mark.parametrize(
    ("there", "right", "found"),
    [
        ("0011100111", "0011100111", (5, 2, 0)),
        ("0011100111", "0011100011", (5, 2, 1)),
        ("1111", "0111", (1, 1, 1)),
        ("1111", "1000", (1, 1, 0)),
        ("0000", "0000", (4, 0, 0)),
    ],
    ids=["right", "wrong at first", "wrong from the start", "wrong later", "never"],
)
def test_a_false_recovery_is_a_first_position_after_a_frame_without_that_is_not_the_targets(
    there: str, right: str, found: tuple[int, int, int]
) -> None:
    assert found_while_sought(bits(there), bits(right)) == found


def test_jerk_cost_is_the_papers_integral_in_units_of_15_ft() -> None:
    t = np.arange(101.0)
    cubic = np.column_stack([2 * t**3, t**2, t]) * PAPER_UNIT  # third derivative (12, 0, 0)
    assert jerk_cost(cubic) == pytest.approx(100 * 12**2)


def test_uniform_acceleration_has_no_jerk_and_gaps_none_either() -> None:
    t = np.arange(40.0) / FPS
    fall = np.column_stack([t, 0 * t, -4.9 * t**2])
    fall[20:] += 7.0
    fall[18:20] = np.nan
    assert jerk_cost(fall) == pytest.approx(0, abs=1e-20)
    assert math.isnan(jerk_cost(fall[:3]))


def test_reprojection_error_is_the_distance_in_the_picture() -> None:
    K = np.array([[200.0, 0, 160], [0, 200, 120], [0, 0, 1]])
    facing = Camera("cam0", "color", (320, 240), K, np.zeros(5), np.eye(3), np.zeros(3))
    turned = Camera("cam1", "color", (320, 240), K, np.zeros(5), np.diag([1.0, -1, -1]), np.zeros(3))
    xyz = still(5, (0, 0, 2))
    room = Room(cameras={"cam0": facing, "cam1": turned})
    one = only(score(tracks(xyz + np.array([0.01, 0, 0])), truth(xyz), room))
    assert one.reprojection_px == pytest.approx(1.0)  # 0.01 m * 200 px / 2 m, behind the other camera
    assert one.reprojection_std_px == pytest.approx(0.0)
    assert math.isnan(only(score(tracks(xyz), truth(xyz))).reprojection_px)


def test_truth_messages_score_like_the_table() -> None:
    def message(frame: int, *objects: str) -> Truth:
        n = len(objects)
        ones = np.ones(n, bool)
        return at(
            frame * 10**9 // 30,
            Truth(objects=objects, xyz=np.full((n, 3), frame), hidden=~ones, trackable=ones, pair=ones),
        )

    got = truth_of([message(0, "a"), message(1, "a", "b")])
    assert got.objects == ("a", "b")
    assert got.trackable.tolist() == [[True, False], [True, True]]
    assert np.isnan(got.xyz[0, 1]).all()
    assert got.xyz[1, 1].tolist() == [1, 1, 1]
    assert truth_of([]).xyz.shape == (0, 0, 3)


def test_table_has_a_line_per_target_and_json_has_no_nan() -> None:
    xyz = still(5, (0, 0, 0), (1, 1, 1))
    scores = score(tracks(xyz), truth(xyz))
    lines = table(scores).splitlines()
    assert [line.split()[0] for line in lines] == ["target", "a", "b"]
    assert "100.0 %" in lines[1]
    parsed = json.loads(json.dumps(to_json(scores), allow_nan=False))
    assert parsed["a"]["rmse_mm"] == 0
    assert parsed["a"]["reprojection_px"] is None


def test_orientations_are_scored_where_both_are_known() -> None:
    xyz = still(4, (1, 2, 3), (2, 2, 2))
    true = np.tile([1.0, 0.0, 0.0, 0.0], (4, 2, 1))
    turned = from_rotation_vector(np.radians([[3.0, 0, 0], [0, 0, -5.0], [0, 0, 0], [0, 0, 0]]))
    turned[2] = np.nan
    rows = tracks(xyz[:, :1])
    scores = score(replace(rows, quaternion=-turned), replace(truth(xyz), quaternion=true))
    assert scores["a"].orientation_deg == pytest.approx(np.sqrt((9 + 25) / 3))
    assert math.isnan(scores["b"].orientation_deg)
    assert "orientation" in table(scores)
    assert "3.4 deg" in table(scores)
    assert "orientation" not in table(score(rows, truth(xyz)))


def test_errors_within_the_ellipsoid_are_counted_by_the_sigma_along_each_axis() -> None:
    """Squared distances of 3 (inside), 7.8 (inside) and 7.83 (outside the limit of 7.81)."""
    xyz = still(4, (1, 2, 3))
    sigma = np.tile([0.001, 0.002, 0.004], (4, 1))
    off = np.array([[1, 1, 1], [2.79285, 0, 0], [0, 0, 2.79821], [1, 0, 0]]) * sigma
    rows = tracks(xyz + off[:, None])
    one = only(score(replace(rows, sigma=sigma), truth(xyz)))
    assert (one.rated_frames, one.within_95) == (4, 0.75)
    assert only(score(replace(rows, sigma=10 * sigma), truth(xyz))).within_95 == 1.0
    assert only(score(replace(rows, sigma=0 * sigma), truth(xyz))).within_95 == 0.0


def test_bridged_frames_are_rated_apart_and_frames_without_sigma_or_truth_not_at_all() -> None:
    xyz = still(6, (0, 0, 0), (3, 3, 3))
    off = np.zeros_like(xyz)
    off[3, 0, 0] = 0.1
    rows = tracks(xyz + off)
    state = rows.state.copy()
    state[rows.target == 0] = [TRACKED, TRACKED, PREDICTED, PREDICTED, PREDICTED, TRACKED]
    sigma = np.full((12, 3), 0.01)
    sigma[(rows.target == 0).nonzero()[0][4]] = np.nan
    xyz[5, 0] = np.nan
    scores = score(replace(rows, state=state, sigma=sigma), truth(xyz, trackable=np.zeros((6, 2), bool)))
    one = scores["a"]
    assert (one.rated_frames, one.within_95, one.bridged_frames, one.bridged_within_95) == (4, 0.75, 2, 0.5)
    assert scores["b"].bridged_frames == 0
    assert math.isnan(scores["b"].bridged_within_95)
    lines = table(scores).splitlines()
    assert "75.0 %" in lines[1]
    assert "50.0 % of 2" in lines[1]
    assert lines[-1] == (
        "all targets: 90.0 % of 10 errors within the ellipsoid of 95 %, 50.0 % of 2 while bridged"
    )
    assert to_json(scores)["a"]["within_95"] == 0.75
    assert to_json(scores)["b"]["bridged_within_95"] is None
