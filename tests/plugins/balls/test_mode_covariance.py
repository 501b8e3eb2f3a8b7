"""What mean shift says of its own errors, against errors that are made on purpose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, forecast_at
from tests.plugins.balls.seen_points import COLOR, HIGH, ROOM, candidates, near, one_ball, undistorted, whole

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.tracking import Candidates, Forecast
from followspot_balls.fusion.mode_covariance import ModeCovariance, rivals_covariance
from followspot_balls.fusion.modes import Modes
from followspot_balls.mean_shift import MeanShift
from followspot_balls.measurement.center_precision import variance
from followspot_balls.measurement.glow_shift import glow_sigma

PLACE = np.array(HIGH)
WEIGHTS = np.array([[1.0, 0.3, 0.8, 0.5, 0.9, 0.2]])
FIRST = np.array([0])
REDUNDANT = 5
"""Of four views: eight coordinates, three unknowns."""


def stage(**params: float) -> MeanShift:
    made = MeanShift(Context(room=ROOM), **params)
    made.setup()
    return made


def seen(xy: Array, area: Array) -> Candidates:
    """The candidates of one blob in each view, (4, 2) and (4,) px, that is the first target."""
    return candidates(list(xy[:, None]), list(area[:, None]), [[[True, False]]] * 4)


def moved(xy: Array) -> Array:
    """The mode of all candidates, (3,) m."""
    return np.asarray((WEIGHTS / WEIGHTS.sum() @ seen(xy, whole(PLACE)).xyz)[0])


def test_the_covariance_is_that_of_errors_of_each_blob_through_all_its_pairs() -> None:
    """Against derivatives by differences, which also know that a pixel off the axis is a smaller angle (3 %);
    0.7 of one blob's outline is hidden, and half of another's.
    """
    exact, step = undistorted(PLACE), 1e-4
    share = np.array([1.0, 0.3, 1.0, 0.5])
    by_blob = np.zeros((3, 3))
    noise = variance(share, 0.2, 4.0, 14.0)
    for view in range(4):
        for axis in range(2):
            off = exact.copy()
            off[view, axis] += step
            derivative = (moved(off) - moved(exact)) / step
            by_blob += noise[view] * np.outer(derivative, derivative)
    covariance = stage().covariance
    area = share * whole(PLACE)
    found = covariance.of(seen(exact, area), FIRST, PLACE[None], WEIGHTS)[0]
    expected = by_blob * 4 / (4 + REDUNDANT)  # the views agree exactly
    assert np.linalg.norm(found - expected) < 0.05 * np.linalg.norm(expected)
    assert np.array_equal(found, found.T)
    twice = covariance.of(seen(exact, area), FIRST, PLACE[None], 2 * WEIGHTS)[0]
    assert twice == pytest.approx(found)


@pytest.mark.parametrize("views", [(0, 1, 2, 3), (0, 1)])
def test_errors_of_modes_are_as_large_as_their_covariances_say(views: tuple[int, ...]) -> None:
    """The mean squared Mahalanobis distance of 400 modes of noisy blobs (NEES) is 3, their dimension."""
    rng, exact, fusion = np.random.default_rng(5), undistorted(PLACE), stage()
    squared = []
    for _ in range(400):
        found = one_ball(exact + rng.normal(0, 0.2, exact.shape), PLACE, views)
        position = fusion.process(found, near())
        error = position.xyz[0] - PLACE
        squared.append(error @ np.linalg.solve(position.covariance[0], error))
    assert 2.5 < np.mean(squared) < 3.4


def test_views_that_disagree_widen_the_covariance() -> None:
    exact = undistorted(PLACE)
    covariance = stage().covariance
    off = exact + np.array([[0.6, 0.0], [0.0, -0.6], [-0.6, 0.0], [0.0, 0.6]])
    alike, apart = (
        covariance.of(seen(xy, whole(PLACE)), FIRST, PLACE[None], WEIGHTS)[0] for xy in (exact, off)
    )
    cost = 4 * (0.6 / 0.2) ** 2
    assert apart == pytest.approx(alike * (4 + cost) / 4, rel=1e-6)


def test_the_light_of_a_ball_on_the_floor_makes_its_place_along_the_normal_vague() -> None:
    """All colour cameras share the shift; the mode follows it as far as their blobs have weight."""
    low = np.array([0.1, -0.2, RADIUS + 0.05])
    lowered = undistorted(low)
    step = 1e-4
    lowered[COLOR] = undistorted(low - [0.0, 0.0, step])[COLOR]
    found = [one_ball(xy, low) for xy in (undistorted(low), lowered)]
    per_metre = (WEIGHTS / WEIGHTS.sum() @ (found[1].xyz - found[0].xyz))[0] / step
    sigma = glow_sigma(np.array(0.05), 0.02, 0.35)
    bright, dark = (
        stage(glow_sigma=s).covariance.of(found[0], FIRST, low[None], WEIGHTS)[0] for s in (0.02, 0.0)
    )
    expected = (1 + 0.3**2) * sigma**2 * np.outer(per_metre, per_metre)
    assert np.linalg.norm(bright - dark - expected) < 0.05 * np.linalg.norm(expected)
    assert bright[2, 2] > 4 * dark[2, 2]


def test_candidates_of_a_depth_camera_have_its_sigma_and_two_cameras_half_the_variance() -> None:
    cameras = {name: replace(c, kind="depth") for name, c in ROOM.cameras.items()}
    made = stage()
    covariance = ModeCovariance(replace(ROOM, cameras=cameras), made.params, 0.008)
    exact = one_ball(undistorted(PLACE), PLACE)
    for views, share in (([0], 1.0), ([0, 2], 0.5)):
        rows = exact.where(np.arange(len(views)))
        found = replace(rows, view=np.repeat(np.array(views, np.int32)[:, None], 2, axis=1))
        of = covariance.of(found, FIRST, PLACE[None], np.ones((1, len(views))))[0]
        assert of == pytest.approx(np.eye(3) * 0.008**2 * share)


@pytest.mark.parametrize(("share", "growth"), [(0.4, 4.0 * 0.6), (1.5, 14.0 * 0.3**2), (1.0, 0.0)])
def test_pairs_of_fragments_and_of_merged_blobs_weigh_by_their_precision(share: float, growth: float) -> None:
    """Two pairs of views, 2 cm apart, of which one shows other areas than a whole ball's."""
    other = PLACE + np.array([0.0, 0.02, 0.0])
    both = two_places(PLACE, other, share)
    position = stage().process(both, near())
    weight = 1 / (1 + growth**2)
    assert position.xyz[0] == pytest.approx((PLACE + weight * other) / (1 + weight), abs=2e-4)
    assert position.support.tolist() == [2]
    assert position.evident.tolist() == [True]


def test_one_blob_that_is_a_fragment_makes_its_pair_less_precise() -> None:
    area = whole(PLACE) * [1.0, 0.4, 1.0, 1.0]
    found = stage().covariance.precision(seen(undistorted(PLACE), area), np.array([1, 0]))
    fragment = 2 / (2 + (4.0 * 0.6) ** 2)
    expected = np.where((seen(undistorted(PLACE), area).view == 1).any(axis=1), fragment, 1.0)
    assert found == pytest.approx(np.array([expected, expected]), rel=1e-6)


@pytest.mark.parametrize("forecast", [None, near(sigma=0.041)], ids=["lost", "vague"])
def test_candidates_in_a_mode_as_wide_as_that_of_a_lost_target_weigh_alike(forecast: Forecast | None) -> None:
    other = PLACE + np.array([0.0, 0.02, 0.0])
    both = two_places(PLACE, other, 0.4)
    assert stage().process(both, forecast).xyz[0] == pytest.approx((PLACE + other) / 2, abs=1e-4)
    nearly = stage().process(both, near(sigma=0.039)).xyz[0]
    assert np.linalg.norm(nearly - PLACE) < 0.2 * np.linalg.norm(nearly - other)


def test_precise_candidates_move_the_place_in_a_mode_but_choose_no_other_mode() -> None:
    """The mode at the forecast is of fragments; 12 cm beside it, two views show a whole ball."""
    other = PLACE + np.array([0.0, 0.12, 0.0])
    found = two_places(other, PLACE, 0.3)
    made = stage(minimum_mode_share=0.4)  # so that the votes of the views are not asked: each mode has half
    assert made.process(found, near(sigma=0.01)).xyz[0] == pytest.approx(PLACE, abs=1e-4)


def test_a_depth_camera_alone_is_as_precise_as_whole_balls() -> None:
    cameras = {name: replace(c, kind="depth") for name, c in ROOM.cameras.items()}
    covariance = ModeCovariance(replace(ROOM, cameras=cameras), stage().params, 0.008)
    pair = seen(undistorted(PLACE), 0.4 * whole(PLACE)).where(np.arange(1))
    alone = replace(pair, view=np.zeros((1, 2), np.int32))
    assert covariance.precision(alone, FIRST).tolist() == [[1.0]]
    assert covariance.precision(pair, FIRST)[0, 0] < 0.2


def two_places(first: Array, second: Array, share: float) -> Candidates:
    """A pair of views of a whole ball, and one of views that show this share of its outline elsewhere."""
    halves = one_ball(undistorted(first), first, (0, 1)), one_ball(undistorted(second), second, (2, 3))
    halves = halves[0], replace(halves[1], area=share * halves[1].area)
    return seal(
        Candidates(
            cameras=halves[0].cameras,
            **{name: np.concatenate([getattr(h, name) for h in halves]) for name in Candidates.array_names},
        )
    )


def test_depth_cameras_that_see_nothing_have_no_mode() -> None:
    cameras = {name: replace(c, kind="depth") for name, c in ROOM.cameras.items()}
    made = MeanShift(Context(room=replace(ROOM, cameras=cameras)))
    made.setup()
    nothing = one_ball(undistorted(PLACE), PLACE).where(np.zeros(0, int))
    assert len(made.process(nothing, None).xyz) == 0


def test_rivals_widen_the_covariance_by_their_spread_and_the_odds_that_they_are_right() -> None:
    xyz = PLACE + np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, -0.2]])
    weights = np.array([[2.0, 1.0, 1.0], [2.0, 0.0, 1.0], [2.0, 0.0, 0.0]])
    held, center = weights * [1.0, 0.0, 0.0], np.tile(PLACE, (3, 1))
    modes = Modes(center, held, held.sum(axis=1), np.ones(3, int))
    found = rivals_covariance(xyz, center, weights, modes, 4.0)
    assert found[0] == pytest.approx(np.diag([0.01, 0.0, 0.04]) / 2 / 2)
    assert found[1] == pytest.approx(np.diag([0.0, 0.0, 0.04]) / 17)
    assert not found[2].any()


def test_a_place_that_as_many_pairs_contradict_is_vague() -> None:
    """Two pairs of views that agree each on a place, 10 cm apart: the deviation is as large."""
    other = PLACE + np.array([0.0, 0.1, 0.0])
    halves = one_ball(undistorted(PLACE), PLACE, (0, 1)), one_ball(undistorted(other), PLACE, (2, 3))
    both = Candidates(
        cameras=halves[0].cameras,
        **{name: np.concatenate([getattr(h, name) for h in halves]) for name in Candidates.array_names},
    )
    forecast = forecast_at([HIGH, (9.0, 9.0, 1.0)], 0.005)
    alone, contradicted = (stage().process(found, forecast).covariance[0] for found in (halves[0], both))
    assert np.sqrt(alone[1, 1]) < 0.02
    assert 0.06 < np.sqrt(contradicted[1, 1]) < 0.12
