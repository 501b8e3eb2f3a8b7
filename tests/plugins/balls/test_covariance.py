"""What the filter believes of its own error stays a covariance, at any rate and through any gap."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.plugins.balls.noises import noises
from tests.plugins.balls.scene import make_room, positions_at

from followspot.context import Context
from followspot.messages import Array, stamped
from followspot.tracking import LOST
from followspot_balls.filtering.motion import Motion, followed, initiated, predict, update
from followspot_balls.kalman import Kalman
from followspot_target_filter.manoeuvre import Bounces

RATES = (0.2, 1.0, 5.0, 12.5, 30.0, 60.0, 120.0, 240.0)
"""Frames per second."""
ACCELERATION, SPEED, GATE = 12.0, 3.0, 3.0


def is_covariance(covariance: Array) -> bool:
    """Whether it is symmetric to the bit, and no variance along any axis is negative beyond rounding."""
    scale = np.sqrt(covariance.diagonal(axis1=1, axis2=2))
    if not (np.array_equal(covariance, covariance.swapaxes(1, 2)) and (scale > 0).all()):
        return False
    correlation = covariance / scale[:, :, None] / scale[:, None]
    return bool(np.linalg.eigvalsh(correlation).min(initial=0.0) > -1e-9)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.thorough) for n in (1, 2, 3))])
def test_the_covariance_of_a_long_run_is_one(rate: float, seed: int) -> None:
    """Sharp and vague measurements along any axis, bounces, gaps of any length."""
    rng, everybody = np.random.default_rng(seed), np.arange(4)
    motion = initiated(Motion.zero(4), everybody, np.zeros((4, 3)), noises(rng, 4, 1e-3, 1e-2), SPEED)
    for _ in range(400):
        motion = predict(motion, rng.choice([1, 1, 1, 2, 40]) / rate, ACCELERATION)
        seen = np.flatnonzero(rng.random(4) > 0.3)
        away = rng.normal(size=(len(seen), 3)) * rng.choice([0.001, 0.02, 1.0])
        noise, sure = noises(rng, len(seen), 1e-6, 3.0), rng.random(len(seen)) > 0.5
        motion = followed(motion, seen, motion.xyz[seen] + away, noise, sure, 1 / rate, Bounces(GATE, SPEED))
        assert is_covariance(motion.covariance[seen])
        assert np.isfinite(motion.sigma).all()


def test_what_a_thousand_updates_leave_is_what_exact_arithmetic_gives() -> None:
    """One axis, place and velocity, in fractions: the filter's variances, to nine digits."""
    rate, noise = 5, Fraction(1, 10**8)
    seconds, acceleration = Fraction(1, rate), Fraction(12)
    a, b, c = noise, Fraction(0), Fraction(9)  # variance of the place, covariance, variance of the velocity
    one = np.array([0])
    motion = initiated(Motion.zero(1), one, np.zeros((1, 3)), np.eye(3)[None] * float(noise), SPEED)
    for step in range(1000):
        a, b = a + 2 * seconds * b + seconds**2 * c, b + seconds * c
        a, b = a + acceleration**2 * seconds**4 / 4, b + acceleration**2 * seconds**3 / 2
        c += acceleration**2 * seconds**2
        motion = predict(motion, float(seconds), float(acceleration))
        if step % 7:  # some frames show nothing
            a, b, c = a - a * a / (a + noise), b - a * b / (a + noise), c - b * b / (a + noise)
            motion, _ = update(motion, one, motion.xyz, np.eye(3)[None] * float(noise))
        a, b, c = (x.limit_denominator(10**40) for x in (a, b, c))
    expected = np.array([[a, b], [b, c]], float)
    assert motion.covariance[0][::3, ::3] == pytest.approx(expected, rel=1e-9)


@settings(deadline=None, max_examples=20)
@given(rate=st.sampled_from(RATES), seed=st.integers(0, 2**32 - 1))
def test_the_stage_knows_its_error_however_balls_are_thrown_and_hidden(rate: float, seed: int) -> None:
    """Balls of up to 10 m/s that are hit now and then, measured as well as the covariances say."""
    rng = np.random.default_rng(seed)
    room = make_room()
    stage = Kalman(Context(room=room))
    stage.setup()
    count, frame = len(room.targets), 0
    place, velocity = np.zeros((2, count, 3))
    with np.errstate(invalid="raise", divide="raise", over="raise"):
        for _ in range(80):
            frames = int(rng.choice([1, 1, 1, 3, 200]))
            frame += frames
            hit = rng.random((count, 1)) < 0.1
            velocity = np.where(hit, rng.uniform(-6, 6, (count, 3)), velocity)
            place = np.clip(place + velocity * frames / rate, -3, 3)
            seen = np.flatnonzero(rng.random(count) > 0.2)
            covariance = noises(rng, len(seen), 1e-5, 0.5)
            measured = [rng.multivariate_normal(p, c) for p, c in zip(place[seen], covariance, strict=True)]
            positions = positions_at(
                dict(zip(seen.tolist(), map(tuple, measured), strict=True)), frame / rate
            )
            outputs = stage.process(stamped(replace(positions, covariance=covariance), positions.header))
            assert np.isfinite(outputs.tracks.sigma).all()
            assert (outputs.tracks.sigma > 0).all()
            assert np.isfinite(outputs.forecast.xyz).all()
            known = outputs.forecast.covariance[outputs.forecast.state != LOST]
            assert (known.diagonal(axis1=1, axis2=2) > 0).all()
