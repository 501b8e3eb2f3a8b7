"""The filter's errors on made motion are as large as it says (Bar-Shalom, Li & Kirubarajan 2001, 5.4).

Limits are those of chi-square with as many degrees of freedom as there are errors, 4 sigmas of its normal
approximation: an average over n errors of dimension d is d +- 4 sqrt(2 d / n).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from tests.plugins.balls.noises import noises

from followspot.messages import Array
from followspot_balls.filtering.motion import Motion, followed, initiated, predict, update
from followspot_target_filter.manoeuvre import Bounces

TARGETS, STEPS, SECONDS = 60, 60, 1 / 30
ACCELERATION, SPEED, GATE = 12.0, 3.0, 3.0
EVERYBODY = np.arange(TARGETS)


class Moment(NamedTuple):
    """One frame of all targets."""

    truth: Array
    """(T, 6) position and velocity, m and m/s."""
    measured: Array
    """(T, 3) m."""
    noise: Array
    """(T, 3, 3) m^2."""


def performance(seed: int) -> Iterator[Moment]:
    """Targets that accelerate by chance and constantly during a frame, measured with noise of any shape."""
    rng = np.random.default_rng(seed)
    place, velocity = np.zeros((TARGETS, 3)), rng.normal(0, SPEED, (TARGETS, 3))
    while True:
        noise = noises(rng, TARGETS, 0.001, 0.02)
        error = np.linalg.cholesky(noise) @ rng.normal(size=(TARGETS, 3, 1))
        yield Moment(np.hstack([place, velocity]), place + error[..., 0], noise)
        acceleration = rng.normal(0, ACCELERATION, (TARGETS, 3))
        place = place + velocity * SECONDS + acceleration * SECONDS**2 / 2
        velocity = velocity + acceleration * SECONDS


def squared(error: Array, covariance: Array) -> Array:
    """Squared Mahalanobis distances: (T, D), (T, D, D) -> (T,)."""
    return np.asarray(np.vecdot(error, np.linalg.solve(covariance, error[..., None])[..., 0]))


def limits(dimension: int, count: int) -> tuple[float, float]:
    """Of an average of `count` squared distances."""
    spread = 4 * np.sqrt(2 * dimension / count)
    return dimension - spread, dimension + spread


@pytest.mark.parametrize("seed", range(3))
def test_squared_errors_and_innovations_average_their_dimension(seed: int) -> None:
    """NEES of place and velocity at any time, NIS over all times; also right after the initiation."""
    frames = performance(seed)
    first = next(frames)
    motion = initiated(Motion.zero(TARGETS), EVERYBODY, first.measured, first.noise, SPEED)
    normalised, innovations = [squared(motion.state - first.truth, motion.covariance)], []
    for now, _ in zip(frames, range(STEPS), strict=False):
        motion = predict(motion, SECONDS, ACCELERATION)
        motion, distance = update(motion, EVERYBODY, now.measured, now.noise)
        innovations.append(distance)
        normalised.append(squared(motion.state - now.truth, motion.covariance))
    low, high = limits(3, TARGETS * STEPS)
    assert low < np.mean(innovations) < high
    means = np.mean(normalised, axis=1)
    low, high = limits(6, TARGETS)
    assert low < means[0] < high
    assert low < means.min()
    assert means.max() < high
    assert 5.6 < means.mean() < 6.4  # of successive frames, which are not independent


@pytest.mark.parametrize("missed", [1, 5, 20])
def test_a_forecast_over_frames_without_measurements_knows_its_error(missed: int) -> None:
    frames = performance(missed)
    first = next(frames)
    motion = initiated(Motion.zero(TARGETS), EVERYBODY, first.measured, first.noise, SPEED)
    for _ in range(20):
        now = next(frames)
        motion = predict(motion, SECONDS, ACCELERATION)
        motion, _ = update(motion, EVERYBODY, now.measured, now.noise)
    for _ in range(missed):
        now = next(frames)
        motion = predict(motion, SECONDS, ACCELERATION)
    low, high = limits(6, TARGETS)
    assert low < squared(motion.state - now.truth, motion.covariance).mean() < high
    now = next(frames)
    motion, distance = update(predict(motion, SECONDS, ACCELERATION), EVERYBODY, now.measured, now.noise)
    low, high = limits(3, TARGETS)
    assert low < distance.mean() < high


def test_after_a_hit_the_error_is_within_what_the_filter_says() -> None:
    """Balls of 6 m/s bounce off a wall in the middle of a frame; the gate notices most, and the rest fits."""
    frames = performance(11)
    first = next(frames)
    motion = initiated(Motion.zero(TARGETS), EVERYBODY, first.measured, first.noise, SPEED)
    rng, sure = np.random.default_rng(12), np.ones(TARGETS, bool)
    for _ in range(20):
        now = next(frames)
        motion = predict(motion, SECONDS, ACCELERATION)
        motion = followed(motion, EVERYBODY, now.measured, now.noise, sure, SECONDS, Bounces(GATE, SPEED))
    jump = np.zeros((TARGETS, 3))
    jump[:, 0] = -12.0
    inside = np.zeros(TARGETS, int)
    since, shift = rng.uniform(0, SECONDS, (TARGETS, 1)), np.zeros((TARGETS, 6))
    for number in range(4):
        now = next(frames)
        shift = np.hstack([jump * (since + number * SECONDS), jump])
        motion = predict(motion, SECONDS, ACCELERATION)
        measured = now.measured + shift[:, :3]
        motion = followed(motion, EVERYBODY, measured, now.noise, sure, SECONDS, Bounces(GATE, SPEED))
        inside += squared((motion.state - now.truth - shift)[:, :3], motion.covariance[:, :3, :3]) < 7.81
    assert inside.mean() / 4 > 0.9
