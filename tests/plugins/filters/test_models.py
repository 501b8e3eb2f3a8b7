"""Transitions of the motion models against the motion that they describe."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_filters.models import (
    ConstantAcceleration,
    ConstantVelocity,
    Forgetful,
    TransitionModel,
    transition,
)

T = 0.04
START = np.array([1.0, -2.0, 3.0, 0.5, 0.0, -4.0, 0.0, 2.0, -9.81])
"""Position, velocity and acceleration: m, m/s, m/s^2."""


def moved(acceleration: float) -> list[float]:
    """Along z after T, by the equations of motion."""
    z, v = START[[2, 5]]
    return [z + v * T + acceleration * T * T / 2, v + acceleration * T]


def test_states_move_by_the_equations_of_motion() -> None:
    F, _ = transition(ConstantAcceleration(1.0), T)
    assert (F @ START)[[2, 5, 8]] == pytest.approx([*moved(-9.81), -9.81])
    F, _ = transition(ConstantVelocity(1.0), T)
    assert (F @ START[:6])[[2, 5]] == pytest.approx(moved(0.0))
    F, _ = transition(Forgetful(ConstantVelocity(1.0), 10.0), T)
    assert (F @ START)[[2, 5, 8]] == pytest.approx([*moved(0.0), 0.0])


def along_z(model: TransitionModel) -> np.ndarray:
    size = model.size // 3
    Q = transition(model, T).Q
    assert np.array_equal(Q, Q.T)
    assert Q[2::3, 0::3].tolist() == np.zeros((size, size)).tolist()
    return Q[2::3, 2::3]


def test_noise_is_that_of_a_random_acceleration_or_jerk_of_each_step() -> None:
    gain = np.array([T**2 / 2, T])
    assert along_z(ConstantVelocity(12.0)) == pytest.approx(144 * np.outer(gain, gain))
    gain = np.array([T**3 / 6, T**2 / 2, T])
    assert along_z(ConstantAcceleration(200.0)) == pytest.approx(200.0**2 * np.outer(gain, gain))


def test_a_bounce_changes_the_velocity_at_any_moment_of_the_step() -> None:
    rng = np.random.default_rng(1)
    change, since = rng.normal(0, 3.0, 200_000), rng.uniform(0, T, 200_000)
    sample = np.cov(change * since, change)
    calm, bounced = (along_z(Forgetful(ConstantVelocity(12.0), 10.0, bounce)) for bounce in (0.0, 3.0))
    assert (bounced - calm)[:2, :2] == pytest.approx(sample, rel=0.02)
    assert calm[2].tolist() == [0.0, 0.0, 100.0]
