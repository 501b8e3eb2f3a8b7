"""Equations 4 to 8 of Jin & Qian 2008 on cases computed by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from tests.plugins.balls.scene import candidates_at, forecast_at, make_room, unweighed

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.stage import Stage
from followspot.tracking import Candidates
from followspot_balls.fusion.kernels import epipolar_weight, kernel, scales, squared_distances
from followspot_balls.fusion.modes import Sample, densest, seek_modes, weighted_mean
from followspot_balls.mean import Mean
from followspot_balls.mean_shift import MeanShift

H = np.array([0.1, 0.2, 0.4])
OFFSETS = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.05, 0.1, 0.2], [0.0, 0.1, 0.0], [0.11, 0.0, 0.0]])


def ready(kind: type[Stage], **params: float | str) -> Stage:
    """The stage; candidates in these tests have no blobs, so views that weigh them would contradict all."""
    stage = kind(Context(room=make_room()), **params)
    stage.setup()
    return unweighed(stage) if isinstance(stage, MeanShift) else stage


def kernel_of(unlabelled: float) -> np.ndarray:
    return kernel(OFFSETS.T[None], scales(H[None]), np.full(len(OFFSETS), unlabelled))[0]


def test_flat_kernel_is_one_inside_the_ellipsoid_only() -> None:
    # squared offsets over squared semi-axes: 0, 1 (on it), 3/4, 1/4, 1.21
    assert kernel_of(unlabelled=0.0).tolist() == [1.0, 0.0, 1.0, 1.0, 0.0]


def test_gaussian_kernel_falls_with_the_widest_bandwidth_and_is_cut_at_the_ellipsoid() -> None:
    expected = [1.0, 0.0, np.exp(-(0.05**2 + 0.1**2 + 0.2**2) / 0.16), np.exp(-0.01 / 0.16), 0.0]
    assert kernel_of(unlabelled=1.0) == pytest.approx(expected)


def test_labelled_candidates_get_the_flat_kernel_and_others_the_gaussian() -> None:
    labelled = np.array([True, True, True, False, False])
    both = kernel(OFFSETS.T[None], scales(H[None]), 1.0 - labelled)[0]
    assert both == pytest.approx([1.0, 0.0, 1.0, np.exp(-0.01 / 0.16), 0.0])


def test_weight_of_epipolar_distance_has_alpha_two_t_squared() -> None:
    assert epipolar_weight(np.array([0.0, 3.0, 6.0]), 3.0) == pytest.approx([1.0, np.exp(-0.5), np.exp(-2.0)])
    assert epipolar_weight(np.array([np.nan, 3.0]), 3.0) == pytest.approx([0.0, np.exp(-0.5)])


@pytest.mark.parametrize("origin", [0.0, 1e4])
def test_distances_are_those_of_offsets_far_from_the_origin_too(origin: float) -> None:
    rng = np.random.default_rng(3)
    points, centers = rng.uniform(-2, 2, (40, 3)) + origin, rng.uniform(-2, 2, (7, 3)) + origin
    scale = np.array([0.25, 1.0, 0.1])
    expected = (np.square(points - centers[:, None]) * scale).sum(axis=2)
    assert squared_distances(points, centers, scale) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("apart", [False, True])
def test_the_densest_candidate_has_the_largest_sum_of_weights_in_its_kernel(apart: bool) -> None:
    rng = np.random.default_rng(5)
    xyz, labelled = rng.uniform(-0.2, 0.2, (30, 3)), rng.random(30) < 0.5
    weights, credit = rng.random((4, 30)) * (rng.random((4, 30)) < 0.6), rng.integers(0, 3, (4, 30)) / 2
    bandwidth = np.tile(H / 2, (4, 1)) * (1 + apart * np.arange(4) % 2)[:, None]
    expected = []
    for mine, trusted, width in zip(weights, credit, bandwidth, strict=True):
        held = kernel(xyz.T - xyz[..., None], np.repeat(scales(width[None]), 30, axis=0), 1.0 - labelled)
        expected.append(xyz[np.where(mine > 0, trusted * (held @ mine), -1).argmax()])
    found = densest(Sample(xyz, labelled, weights, bandwidth), credit)
    assert found.tolist() == np.array(expected).tolist()


def test_one_step_is_the_weighted_mean_of_what_the_kernel_holds() -> None:
    xyz = np.array([[0.0, 0.0, 0.0], [0.06, 0.0, 0.0], [5.0, 0.0, 0.0]])
    sample = Sample(xyz, np.ones(3, bool), np.array([[1.0, 0.5, 1.0]]), np.full((1, 3), 0.1))
    modes = seek_modes(np.array([[0.01, 0.0, 0.0]]), sample, 0.0005, 1)
    assert modes.center[0] == pytest.approx([0.02, 0.0, 0.0])
    assert modes.held[0] == pytest.approx([1.0, 0.5, 0.0])


def test_a_centre_rests_when_its_step_is_shorter_than_half_a_millimetre() -> None:
    xyz = np.array([[0.0, 0.0, 0.0]])
    sample = Sample(xyz, np.ones(1, bool), np.ones((2, 1)), np.full((2, 3), 0.1))
    start = np.array([[0.0004, 0.0, 0.0], [0.0006, 0.0, 0.0]])
    assert seek_modes(start, sample, 0.0005, 30).steps.tolist() == [1, 2]


def test_an_empty_kernel_stays_where_it_is() -> None:
    sample = Sample(np.zeros((1, 3)), np.ones(1, bool), np.ones((1, 1)), np.full((1, 3), 0.1))
    modes = seek_modes(np.array([[1.0, 0.0, 0.0]]), sample, 0.0005, 30)
    assert modes.center.tolist() == [[1.0, 0.0, 0.0]]
    assert not modes.held.any()


@settings(deadline=None, max_examples=50)
@given(arrays(float, (6, 3), elements=st.floats(-0.2, 0.2)))
def test_a_mode_lies_within_the_candidates(xyz: np.ndarray) -> None:
    sample = Sample(xyz, np.ones(6, bool), np.ones((1, 6)), np.full((1, 3), 0.1))
    modes = seek_modes(densest(sample, np.ones((1, 6))), sample, 0.0005, 30)
    assert (modes.center >= xyz.min(axis=0) - 1e-12).all()
    assert (modes.center <= xyz.max(axis=0) + 1e-12).all()
    assert modes.held.any()


def test_mean_shift_ignores_the_biased_candidate_that_the_mean_takes() -> None:
    found = candidates_at([(0.0, 0.0, 1.0), (0.004, 0.0, 1.0), (0.002, 0.0, 1.0), (0.15, 0.0, 1.0)])
    forecast = forecast_at([(0.01, 0.0, 1.0)])
    assert ready(MeanShift).process(found, forecast).xyz[0] == pytest.approx([0.002, 0.0, 1.0], abs=1e-9)
    assert Mean().process(found, forecast).xyz[0] == pytest.approx([0.039, 0.0, 1.0])


def test_mean_shift_follows_candidates_metres_away_where_there_are_no_others() -> None:
    found = candidates_at([(5.0, 0.0, 1.0), (5.01, 0.0, 1.0)])
    position = ready(MeanShift).process(found, forecast_at([(0.0, 0.0, 1.0)]))
    assert position.xyz[0] == pytest.approx([5.005, 0.0, 1.0], abs=1e-6)


def test_each_target_takes_its_own_candidates_and_shares_unlabelled_ones() -> None:
    found = candidates_at(
        [(0.0, 0.0, 1.0), (0.17, 0.0, 1.0), (0.0, 0.01, 1.0)],
        labelled=[True, True, False],
        confirmed=[True, True, False],
        targets=[[True, False], [False, True], [True, True]],
    )
    position = ready(MeanShift).process(found, forecast_at([(0.0, 0.0, 1.0), (0.17, 0.0, 1.0)]))
    assert position.target.tolist() == [0, 1]
    assert position.xyz[1] == pytest.approx([0.17, 0.0, 1.0])
    assert position.support.tolist() == [2, 1]


@pytest.mark.parametrize("fusion", [MeanShift, Mean])
def test_a_lost_target_gets_no_position_without_a_color_infrared_pair(fusion: type) -> None:
    places = [(0.0, 0.0, 1.0), (0.001, 0.0, 1.0)]
    assert len(ready(fusion).process(candidates_at(places, confirmed=[False, False]), None).target) == 0
    assert len(ready(fusion).process(candidates_at(places, confirmed=[True, False]), None).target) == 1


@pytest.mark.parametrize(
    ("view", "evident", "support"),
    [
        ([(0, 1), (1, 2), (0, 2)], True, 3),  # each of three views with both others
        ([(0, 1), (1, 2), (0, 2)], False, 1),
        ([(0, 1), (1, 2), (2, 3)], True, 1),  # a chain of four
        ([(0, 1), (0, 1), (0, 1)], True, 1),  # two views
    ],
)
def test_pairs_of_three_views_may_agree_less_well_for_a_target_that_appears(
    view: list[tuple[int, int]], evident: bool, support: int
) -> None:
    places = [(0.0, 0.0, 1.0), (0.01, 0.0, 1.0), (0.0, 0.01, 1.0)]
    exact = candidates_at(places, epipolar=[0.1, 2.5, 2.9], view=view)
    found = seal(Candidates(**{**vars(exact), "evident": np.array([evident, False, False])}))
    fuse, narrow = ready(MeanShift), ready(MeanShift, recovery_epipolar_sigma=1.0)
    assert fuse.process(found, None).support.tolist() == [support]
    assert fuse.process(found, forecast_at([(0.0, 0.0, 1.0)])).support.tolist() == [1]
    assert narrow.process(found, None).support.tolist() == [1]


@pytest.mark.parametrize("start", ["forecast", "densest", "mean"])
def test_every_initial_centre_finds_a_single_cluster(start: str) -> None:
    found = candidates_at([(0.001 * i, 0.0, 1.0) for i in range(5)])
    position = ready(MeanShift, initial_center=start).process(found, forecast_at([(0.01, 0.0, 1.0)]))
    assert position.xyz[0] == pytest.approx([0.002, 0.0, 1.0])
    assert position.iterations[0] >= 1


@pytest.mark.parametrize("confirmed", [True, False])
def test_position_without_support_says_whether_an_evident_pair_shows_it(confirmed: bool) -> None:
    found = candidates_at([(0.0, 0.0, 1.0)], confirmed=[confirmed], epipolar=[1.5])
    position = ready(MeanShift).process(found, forecast_at([(0.0, 0.0, 1.0)]))
    assert position.support.tolist() == [0]
    assert position.evident.tolist() == [confirmed]


def test_the_weighted_mean_is_that_of_each_row_and_zero_without_weights() -> None:
    xyz = np.array([[1.0, 2.0, 3.0], [5.0, 2.0, -1.0]])
    weights = np.array([[1.0, 3.0], [2.0, 0.0], [0.0, 0.0], [1.0, 1.0]])
    assert weighted_mean(xyz, weights) == pytest.approx(
        np.array([[4, 2, 0], [1, 2, 3], [0, 0, 0], [3, 2, 1]])
    )
