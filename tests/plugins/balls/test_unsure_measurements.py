"""A measurement that few candidates show may be of something else: the filter stays ready for both."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at

from followspot.context import Context
from followspot.messages import Array
from followspot_balls.filtering.motion import Motion, followed, initiated, predict
from followspot_balls.kalman import Kalman
from followspot_target_filter.association_probability import association_probability, mixed
from followspot_target_filter.manoeuvre import Bounces

SECONDS, ACCELERATION, SPEED, GATE = 1 / 30, 12.0, 3.0, 3.0
SIGMA = 0.008
NOISE = np.eye(3)[None] * SIGMA**2
ONE = np.array([0])
VELOCITY = np.array([1.0, 0.5, 0.0])


def place(step: int) -> Array:
    """A target that moves steadily, m."""
    return VELOCITY * step * SECONDS


def after(motion: Motion, xyz: Array, sure: bool) -> Motion:
    motion = predict(motion, SECONDS, ACCELERATION)
    return followed(motion, ONE, xyz[None], NOISE, np.array([sure]), SECONDS, Bounces(GATE, SPEED))


def tracked(steps: int) -> Motion:
    """The motion of the target after exact and sure measurements."""
    motion = initiated(Motion.zero(1), ONE, place(0)[None], NOISE, SPEED)
    for step in range(1, steps):
        motion = after(motion, place(step), True)
    return motion


def squared(motion: Motion, xyz: Array) -> float:
    """Normalised innovation squared of a measurement in the next frame."""
    ahead = predict(motion, SECONDS, ACCELERATION)
    n = xyz - ahead.xyz[0]
    return float(n @ np.linalg.solve(ahead.covariance[0, :3, :3] + NOISE[0], n))


def spread() -> float:
    """Sigma of the innovations of the tracked target, m."""
    ahead = predict(tracked(20), SECONDS, ACCELERATION)
    return float(np.sqrt(ahead.covariance[0, 2, 2] + NOISE[0, 2, 2]))


@pytest.mark.parametrize("sigmas", [2.5, 2.9, 3.1, 4.0, 8.0, 30.0])
def test_after_an_unsure_measurement_the_target_is_in_the_gate_wherever_it_is(sigmas: float) -> None:
    """Whether the measurement was of something else, or the target was hit and goes on from there."""
    away = np.array([0.0, 0.0, sigmas * spread()])
    motion = after(tracked(20), place(20) + away, False)
    assert squared(motion, place(21)) < GATE
    assert squared(motion, place(21) + away) < GATE


def test_an_unsure_measurement_at_the_forecast_counts_as_a_sure_one() -> None:
    sure, unsure = (after(tracked(20), place(20), sure) for sure in (True, False))
    assert np.abs(sure.xyz - unsure.xyz).max() < 1e-4
    assert unsure.covariance[0, 0, 0] == pytest.approx(sure.covariance[0, 0, 0], rel=0.1)


def test_a_target_that_only_unsure_measurements_show_is_followed_after_a_hit() -> None:
    motion = tracked(20)
    for step in range(20, 26):
        hit = place(step) + np.array([0.0, 0.0, 4.0 * (step - 19) * SECONDS])
        motion = after(motion, hit, False)
    assert np.linalg.norm(motion.xyz[0] - hit) < SIGMA
    assert motion.velocity[0, 2] == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize(
    ("support", "evident", "share"), [(3, False, 1.0), (2, True, 1.0), (2, False, 0.5), (1, True, 0.5)]
)
def test_a_hit_is_followed_at_once_if_enough_candidates_show_it(
    support: int, evident: bool, share: float
) -> None:
    stage = Kalman(Context(room=make_room()))
    stage.setup()
    for frame in range(20):
        stage.process(positions_at({0: (0.0, 0.0, 1.0)}, frame * SECONDS, sigma=SIGMA))
    hit = positions_at({0: (0.0, 0.0, 1.4)}, 20 * SECONDS, support=support, evident=evident, sigma=SIGMA)
    assert stage.process(hit).tracks.xyz[0, 2] - 1.0 == pytest.approx(0.4 * share, abs=0.01)


def test_errors_are_as_large_as_stated_though_some_measurements_are_false() -> None:
    """Half of the measurements are unsure, and one in seven of these is of something 5 cm off."""
    rng, count = np.random.default_rng(1), 400
    every, noise = np.arange(count), np.tile(NOISE, (400, 1, 1))
    xyz, velocity = np.zeros((count, 3)), rng.normal(0, 1, (count, 3))
    motion = initiated(Motion.zero(count), every, rng.normal(0, SIGMA, xyz.shape), noise, SPEED)
    inside = []
    for _ in range(60):
        acceleration = rng.normal(0, ACCELERATION, xyz.shape)
        xyz = xyz + velocity * SECONDS + acceleration * SECONDS**2 / 2
        velocity = velocity + acceleration * SECONDS
        sure = rng.random(count) < 0.5
        false = ~sure & (rng.random(count) < 1 / 7)
        measured = xyz + rng.normal(0, SIGMA, xyz.shape) + false[:, None] * rng.normal(0, 0.05, xyz.shape)
        motion = followed(
            predict(motion, SECONDS, ACCELERATION),
            every,
            measured,
            noise,
            sure,
            SECONDS,
            Bounces(GATE, SPEED),
        )
        error = motion.xyz - xyz
        spread = np.linalg.solve(motion.covariance[:, :3, :3], error[..., None])[..., 0]
        inside.append(np.vecdot(error, spread) < 7.81)
    assert 0.93 < np.mean(inside) < 0.97  # of 95 %


def test_at_the_gate_and_beyond_either_is_as_likely() -> None:
    found = association_probability(np.array([0.0, 4.0, 9.0, 100.0, 1e6]), 3.0)
    assert found == pytest.approx([1 / (1 + np.exp(-4.5)), 1 / (1 + np.exp(-2.5)), 0.5, 0.5, 0.5])


def test_a_mixture_has_the_moments_of_samples_of_both() -> None:
    rng = np.random.default_rng(3)
    means, factors = rng.normal(size=(2, 2)), rng.normal(size=(2, 2, 2))
    P = factors @ factors.swapaxes(1, 2)
    x, covariance = mixed(means[:1], P[:1], means[1:], P[1:], np.array([0.3]))
    samples = [
        rng.multivariate_normal(mean, one, size)
        for mean, one, size in zip(means, P, (300_000, 700_000), strict=True)
    ]
    assert x[0] == pytest.approx(np.concatenate(samples).mean(axis=0), abs=0.01)
    assert covariance[0] == pytest.approx(np.cov(np.concatenate(samples).T), abs=0.02)
