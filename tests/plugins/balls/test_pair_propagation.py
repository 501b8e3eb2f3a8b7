"""Errors of rays in points of pairs, against the normal equations of each pair."""

from __future__ import annotations

import numpy as np

from followspot_balls.pairs.error_propagation import propagation


def test_it_is_the_solution_of_the_normal_equations_of_each_pair_weighted() -> None:
    rng = np.random.default_rng(1)
    rays = rng.normal(size=(3, 5, 3))
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    weight = rng.uniform(size=(3, 5, 5)) * (1 - np.eye(5))
    weight += weight.swapaxes(1, 2)
    variance = rng.uniform(0.5, 2.0, (3, 5))
    across = np.eye(3) - rays[..., None] * rays[:, :, None]
    information = across / variance[..., None, None]
    expected = np.zeros((3, 5, 3, 3))
    for mode, view, other in np.argwhere(weight):
        both = information[mode, view] + information[mode, other]
        expected[mode, view] += weight[mode, view, other] * np.linalg.solve(both, information[mode, view])
    np.testing.assert_allclose(propagation(weight, rays, variance), expected, atol=1e-9)


def test_rays_without_a_pair_and_parallel_rays_leave_it_finite() -> None:
    rays = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]])
    weight = np.array([[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    found = propagation(weight, rays, np.ones((1, 3)))
    assert np.isfinite(found).all()
    assert not found[0, 2].any()
