"""A robust fit that rejected views says how far off it is if these are right."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.seen_points import HIGH, bundle, near, one_ball, undistorted

from followspot_balls.fusion.contradiction import contradicted, nearest_shifts


def test_the_shift_to_an_error_is_the_smallest_one() -> None:
    rng = np.random.default_rng(2)
    jacobian, errors = rng.normal(size=(5, 3, 2, 3)), rng.normal(size=(5, 3, 2))
    expected = (np.linalg.pinv(jacobian) @ errors[..., None])[..., 0]
    assert nearest_shifts(jacobian, errors) == pytest.approx(expected)


def test_rejected_views_count_by_their_spread_and_the_odds_that_they_are_right() -> None:
    """Two views from above, 100 px/m; a step of 1 cm explains part of what the second one sees."""
    design = np.zeros((1, 4, 5))
    design[0, :, :3] = 100.0 * np.array([[1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0]])
    design[0, :, 4] = [1.0, 0.0, 5.0, -3.0]
    step = np.array([[0.01, 0.0, 0.0, 0.0]])
    off = np.array([0.04, -0.03, 0.0])
    both = np.ones((1, 2), bool)
    found = contradicted(design, step, np.array([[1.0, 0.0]]), both, 6.0)
    assert found[0] == pytest.approx(np.outer(off, off) / 2)
    found = contradicted(design, step, np.array([[1.0, 0.5]]), both, 6.0)
    assert found[0] == pytest.approx(np.outer(off, off) / (1 + 3.0**6))
    found = contradicted(design, step, np.array([[0.25, 0.0]]), both, 6.0)
    assert found[0] == pytest.approx(np.outer(off, off) / 1.75 / 2)  # the first view fits after the step
    none = contradicted(design, step, np.array([[1.0, 0.0]]), np.array([[True, False]]), 6.0)
    assert not none.any()


def test_a_place_that_half_of_the_views_reject_is_vague_and_one_that_one_rejects_is_not() -> None:
    place = np.array(HIGH)
    exact, off = undistorted(place), np.array([10.0, 0.0])
    one, two = exact.copy(), exact.copy()
    one[3] += off
    two[2] += off
    two[3] -= off
    deviations = [
        np.sqrt(np.trace(bundle().process(one_ball(xy, place), near()).covariance[0]))
        for xy in (exact, one, two)
    ]
    assert deviations[0] < 0.005
    assert deviations[1] < 3 * deviations[0]
    assert deviations[2] > 0.08
