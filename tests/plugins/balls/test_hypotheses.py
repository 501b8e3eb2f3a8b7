"""Hypotheses: as forecast or a jump to a candidate, at the position that prior and views make likeliest."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import forecast_at, make_room

from followspot.messages import Array
from followspot_balls.association.hypotheses import (
    Hypotheses,
    MotionPrior,
    gauss_newton_step,
    hypotheses,
    jacobians,
)
from followspot_balls.measurement.points import point_images

PRIOR = MotionPrior(added=0.01, jump=0.1, jump_probability=0.02, reach=0.15)
HERE, THERE = (0.1, 0.2, 1.2), (-1.0, 0.0, 0.5)
BESIDE = np.array(HERE) + np.array([0.05, -0.05, 0.05])
P = np.array([camera.projection for camera in make_room().cameras.values()])


def one(xyz: Array, mean: Array, sigma: float) -> Hypotheses:
    none = np.zeros(1)
    return Hypotheses(xyz[None], np.zeros(1, int), np.zeros(1, int), mean[None], none + sigma**2, none)


def test_a_tracked_target_moves_as_forecast_or_jumps_to_a_candidate() -> None:
    xyz = np.array([(0.3, 0.2, 1.2), (0.0, 0.0, 1.0), (0.5, 0.5, 0.5)])
    forecast = forecast_at([HERE, THERE], sigma=0.03)
    found = hypotheses(
        xyz, np.array([0, 2, 1]), np.array([0, 0, 1]), forecast, np.array([True, False]), PRIOR
    )
    assert found.row.tolist() == [0, 2, 1, -1]
    assert found.target.tolist() == [0, 0, 1, 0]
    assert found.xyz == pytest.approx(np.array([xyz[0], xyz[2], xyz[1], HERE]))
    assert found.mean == pytest.approx(np.array([HERE, HERE, xyz[1], HERE]))
    assert found.variance == pytest.approx([0.0109, 0.0109, 0.15**2, 0.001])
    assert found.weight == pytest.approx([np.log(0.02), np.log(0.02), 0, np.log(0.98)])


def test_a_tracked_target_without_candidates_has_no_hypothesis() -> None:
    nothing = np.zeros(0, int)
    forecast = forecast_at([HERE, THERE])
    assert not len(hypotheses(np.zeros((0, 3)), nothing, nothing, forecast, np.ones(2, bool), PRIOR).row)


def test_without_a_forecast_each_candidate_is_a_hypothesis() -> None:
    found = hypotheses(np.array([HERE]), np.zeros(1, int), np.ones(1, int), None, np.ones(2, bool), PRIOR)
    assert found.row.tolist() == [0]
    assert found.improbability() == pytest.approx([0])


def test_improbability_is_half_the_squared_sigmas_less_the_weight() -> None:
    found = one(np.array(HERE), np.array(HERE) - np.array([0.03, 0, 0.04]), 0.025)._replace(
        weight=np.array([-1.5])
    )
    assert found.improbability() == pytest.approx([2.0 + 1.5])


def test_jacobians_are_the_derivatives_of_images() -> None:
    place, small = np.array([HERE]), 1e-6
    seen = point_images(P, place)
    expected = [
        (point_images(P, place + small * axis).xy - point_images(P, place - small * axis).xy) / (2 * small)
        for axis in np.eye(3)
    ]
    assert jacobians(P, seen.xy, seen.depth) == pytest.approx(np.stack(expected, axis=-1), abs=1e-5)


def moved(sigma: float, weight: list[float]) -> Array:
    """Where steps lead from 9 cm beside a ball that four views show, with a prior around the start."""
    ball, found = point_images(P, np.array([HERE])).xy, one(BESIDE, BESIDE, sigma)
    for _ in range(4):
        seen = point_images(P, found.xyz)
        error = ball - seen.xy
        found = found.moved(
            found.xyz + gauss_newton_step(found, jacobians(P, seen.xy, seen.depth), error, np.array([weight]))
        )
    return np.asarray(found.xyz[0])


def test_steps_lead_to_the_ball_that_the_views_show() -> None:
    assert moved(1e3, [1.0, 1.0, 1.0, 1.0]) == pytest.approx(HERE, abs=1e-6)
    assert moved(1e3, [1.0, 0.0, 1.0, 0.0]) == pytest.approx(HERE, abs=1e-6), "two views are enough"


def test_the_prior_holds_what_no_view_shows() -> None:
    assert moved(0.02, [0.0] * 4) == pytest.approx(BESIDE)
    depth = moved(0.02, [50.0, 0.0, 0.0, 0.0]) - np.array(HERE)
    ray = np.array(HERE) - (3.0, 0.0, 3.0)
    ray /= np.linalg.norm(ray)
    assert np.linalg.norm(depth - (depth @ ray) * ray) < 0.01, "across the ray the view decides"
    assert abs(depth @ ray) > 0.005, "along it the prior"


def test_a_precise_prior_and_vague_views_meet_between() -> None:
    far, near = (np.linalg.norm(moved(0.02, [w] * 4) - HERE) for w in (0.05, 50.0))
    assert 0.02 < far < 0.087
    assert near < 0.005


def test_without_views_a_place_goes_to_the_mean_of_its_prior() -> None:
    found = one(np.array(HERE), BESIDE, 0.02)
    seen = point_images(P, found.xyz)
    error, nothing = np.ones((1, 4, 2)), np.zeros((1, 4))
    taken = gauss_newton_step(found, jacobians(P, seen.xy, seen.depth), error, nothing)
    assert taken == pytest.approx((BESIDE - HERE)[None])
