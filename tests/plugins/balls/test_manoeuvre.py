"""Bounces and hits: a measurement that the forecast makes improbable is followed, others are smoothed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.plugins.balls.scene import make_room, positions_at

from followspot.context import Context
from followspot.messages import Array
from followspot_balls.filtering.motion import Motion, initiated, manoeuvred, predict, update
from followspot_balls.kalman import Kalman
from followspot_target_filter.manoeuvre import Bounces, jump

T = 0.04
SPEED = 3.0
NOISE = np.eye(3) * 0.008**2


def flying() -> Motion:
    """Two targets at 2 m/s along x that were measured well, predicted to x = 0."""
    motion = initiated(Motion.zero(2), np.array([0, 1]), np.zeros((2, 3)), np.stack([NOISE] * 2), 0.5)
    motion.state[:, 0], motion.state[:, 3] = -2.0 * T, 2.0
    return predict(motion, T, 12.0)


def given_way(motion: Motion, place: Array, gate: float = 3.0) -> Motion:
    return manoeuvred(motion, np.array([1]), place[None], NOISE[None], T, Bounces(gate, SPEED))


def squared_distance(motion: Motion, place: Array) -> float:
    innovation = place - motion.xyz[1]
    return float(innovation @ np.linalg.solve(motion.covariance[1, :3, :3] + NOISE, innovation))


@settings(deadline=None)
@given(st.tuples(*[st.floats(-1, 1)] * 3))
def test_an_improbable_measurement_becomes_one_of_one_sigma(place: tuple[float, ...]) -> None:
    motion, measured = flying(), np.array(place)
    if squared_distance(motion, measured) > 9.0:
        assert squared_distance(given_way(motion, measured), measured) == pytest.approx(1.0, rel=1e-6)
    else:
        assert given_way(motion, measured) is motion


def test_only_the_target_that_jumped_gives_way() -> None:
    motion = flying()
    changed = given_way(motion, np.array([0.0, 0.0, 0.3]))
    assert np.array_equal(changed.covariance[0], motion.covariance[0])
    assert np.array_equal(changed.state, motion.state)
    assert np.linalg.eigvalsh(changed.covariance[1]).min() > 0


def test_a_bounce_is_followed_at_once_and_lost_sight_of_without_the_gate() -> None:
    bounced = np.array([0.0, 0.0, 0.2])
    for gate, error in ((3.0, 0.002), (1e9, 0.02)):
        motion, _ = update(given_way(flying(), bounced, gate), np.array([1]), bounced[None], NOISE[None])
        left = np.linalg.norm(motion.xyz[1] - bounced)
        assert (left < error) == (gate == 3.0)


def test_a_velocity_that_jumped_at_any_moment_of_the_step_moves_the_place_that_long() -> None:
    # E[s^2], E[s] and 1 for s uniform in 0 to T, relative to the first
    since = (np.arange(100_000) + 0.5) / 100_000 * T
    expected = np.array([[np.square(since).mean(), since.mean()], [since.mean(), 1.0]])
    assert jump(T) == pytest.approx(expected / expected[0, 0], rel=1e-6)


def returned(sigma: float, way: float) -> Motion:
    """A target at rest that vague measurements show elsewhere, and then an exact one shows in its place.

    sigma: of the vague measurements, m; way: distance between these and the exact one, m.
    """
    one, vague = np.array([0]), np.eye(3)[None] * sigma**2
    motion = initiated(Motion.zero(1), one, np.array([[way, 0.0, 0.0]]), NOISE[None], SPEED)
    for _ in range(10):
        motion, _ = update(predict(motion, T, 12.0), one, np.array([[way, 0.0, 0.0]]), vague)
    exact = one, np.zeros((1, 3)), NOISE[None]
    motion = manoeuvred(predict(motion, T, 12.0), *exact, T, Bounces(3.0, SPEED))
    return update(motion, *exact)[0]


@pytest.mark.parametrize("way", [0.2, 0.25, 0.3])
def test_a_track_that_vague_measurements_led_away_returns_and_stays(way: float) -> None:
    motion = returned(0.04, way)
    assert np.linalg.norm(motion.xyz[0]) < 0.02
    # As far again and farther after a bounce.
    assert np.linalg.norm(predict(motion, T, 12.0).xyz[0]) < way / 2
    # Ready for any velocity.
    assert motion.covariance[0, 3:, 3:].diagonal().min() > (SPEED / 2) ** 2


def test_a_target_that_was_measured_well_is_hit_and_goes_on() -> None:
    motion = returned(0.008, 0.15)
    assert np.linalg.norm(motion.xyz[0]) < 0.01
    assert predict(motion, T, 12.0).xyz[0, 0] < -0.1


def filtered(time: Array, places: Array, gate: float) -> Array:
    """What the stage makes of measured places, (N, 3) m."""
    stage = Kalman(Context(room=make_room(("red",))), bounce_gate=gate)
    stage.setup()
    messages = (positions_at({0: tuple(p)}, t) for t, p in zip(time, places, strict=True))
    return np.array([stage.process(message).tracks.xyz[0] for message in messages])


def test_the_filter_follows_bounces_and_smooths_the_flight_between_them() -> None:
    time = np.arange(300) * T
    height = np.abs(2.0 - 5.0 * time % 4.0)  # 5 m/s down and up, as between two elastic floors
    places = np.column_stack([time, np.zeros_like(time), height])
    noisy = places + np.random.default_rng(2).normal(0, 0.008, places.shape)
    raw, gated, stiff = (
        np.linalg.norm(found - places, axis=1)
        for found in (noisy, filtered(time, noisy, 3.0), filtered(time, noisy, 1e9))
    )
    turned = np.zeros(len(time), bool)
    turned[2:] = np.abs(np.diff(height, 2)) > 0.05
    assert gated[turned].mean() < 1.1 * raw[turned].mean()
    assert stiff[turned].mean() > 1.5 * raw[turned].mean()
    assert gated[~turned].mean() < 0.95 * raw[~turned].mean()
