"""Robust estimation of points: what beliefs add up to, and how errors scale the covariance."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_balls.measurement.points import Belief, Equations, empty_belief, estimated, solved


def belief(information: float, mean: float) -> Belief:
    """All four parameters alike."""
    return Belief(np.full((1, 4), information * mean), np.eye(4)[None] * information)


def equations(views: list[float], cost: float) -> Equations:
    """Those of views with these weights, which say that the step is 1 along each parameter."""
    return Equations(np.eye(4)[None] * 4.0, np.full((1, 4), 4.0), np.array([views]), np.array([cost]))


def test_independent_beliefs_meet_at_the_mean_by_their_information() -> None:
    both = belief(1.0, 0.0).and_also(belief(3.0, 2.0))
    assert both.information == pytest.approx(np.eye(4)[None] * 4.0)
    assert np.linalg.solve(both.information[0], both.vector[0]) == pytest.approx([1.5] * 4)
    assert both.relative(np.ones((1, 4))).vector == pytest.approx(np.full((1, 4), 2.0))


def test_a_step_lies_between_that_of_the_views_and_that_of_the_belief() -> None:
    step, covariance = estimated(equations([1.0, 1.0], 1.0), belief(12.0, 0.0), 4.0)
    assert step == pytest.approx(np.full((1, 4), 0.25))
    assert step == pytest.approx(solved(equations([1.0, 1.0], 1.0), belief(12.0, 0.0)))
    assert covariance == pytest.approx(np.eye(3)[None] / 16)


@pytest.mark.parametrize(
    ("views", "redundant"),
    [([1.0] * 4, 5.0), ([1.0, 1.0], 1.0), ([1.0, 0.0], 0.0), ([1.0, 1.0, 0.25], 1.5)],
)
def test_errors_beyond_the_redundant_coordinates_scale_the_covariance(
    views: list[float], redundant: float
) -> None:
    """Each view has two coordinates, three of all are unknown; the prior counts as four errors of 1."""
    _, covariance = estimated(equations(views, 14.0), empty_belief(1), 4.0)
    assert covariance == pytest.approx(np.eye(3)[None] / 4 * (4 + 14) / (4 + redundant))
