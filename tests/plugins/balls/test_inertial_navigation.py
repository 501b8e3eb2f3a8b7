"""The navigation's linear algebra against differences of the formulas that it linearises."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import Array
from followspot.rotation import from_rotation_vector, matrix, rotation_vector
from followspot_balls.inertial.initiation import initiated, reinitiated
from followspot_balls.inertial.navigation import (
    ACCELERATION,
    ARM,
    DELAY,
    GYRO,
    POSITION,
    ROTATION,
    SIZE,
    VELOCITY,
    Navigation,
    coasted,
    corrected,
    predicted_position,
    propagated,
)
from followspot_balls.inertial.process_noise import Densities, add_noise, of_readings
from followspot_balls.inertial.rotation_matrices import quaternion_of, rotation_exp
from followspot_balls.inertial.sensor_errors import SensorErrors

EXACT = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.02, 0.1, 0.03, 0.005)
STEP = 1e-5
FORCE = (5.0, -3.0, 9.81)
NOISE = np.diag([1e-5, 2e-5, 3e-5])
SIGMA = np.array([0.02, 0.02, 0.1])


def example(seed: int = 0) -> Navigation:
    """A settled navigation with values and covariances of all kinds."""
    rng = np.random.default_rng(seed)
    nav = initiated(np.array([0.5, -0.5, 0.5, 0.5]), SIGMA, rng.normal(size=3), NOISE, EXACT)
    spread = rng.normal(size=(SIZE, SIZE)) * 1e-3
    return nav._replace(
        velocity=rng.normal(size=3),
        gyroscope_bias=0.1 * rng.normal(size=3),
        accelerometer_bias=0.1 * rng.normal(size=3),
        lever_arm=0.1 * rng.normal(size=3),
        delay=0.004,
        covariance=spread @ spread.T + 1e-7 * np.eye(SIZE),
        turn_rate=rng.normal(size=3),
        acceleration=rng.normal(size=3),
    )


def moved(nav: Navigation, error: Array) -> Navigation:
    """The state with an error (19,) added."""
    return nav._replace(
        rotation=rotation_exp(error[ROTATION]) @ nav.rotation,
        velocity=nav.velocity + error[VELOCITY],
        position=nav.position + error[POSITION],
        gyroscope_bias=nav.gyroscope_bias + error[GYRO],
        accelerometer_bias=nav.accelerometer_bias + error[ACCELERATION],
        lever_arm=nav.lever_arm + error[ARM],
        delay=nav.delay + float(error[DELAY]),
    )


def away(a: Navigation, b: Navigation) -> Array:
    """The error of a state from another, (19,)."""
    rotation = rotation_vector(quaternion_of(a.rotation @ b.rotation.T))
    parts = [rotation, a.velocity - b.velocity, a.position - b.position]
    parts += [a.gyroscope_bias - b.gyroscope_bias, a.accelerometer_bias - b.accelerometer_bias]
    return np.concatenate([*parts, a.lever_arm - b.lever_arm, [a.delay - b.delay]])


def readings(seed: int = 1) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    rates, forces = rng.normal(size=(2, 4, 3))
    return rates, forces + np.array([0.0, 0.0, 9.81]), np.array([5, 4, 5, 6]) * 1e-3


@pytest.mark.parametrize("component", range(SIZE))
def test_an_error_grows_as_its_covariance(component: int) -> None:
    error = np.eye(SIZE)[component] * STEP
    nav = example()._replace(covariance=np.outer(error, error))
    after = propagated(nav, *readings(), EXACT)
    grown = away(propagated(moved(nav, error), *readings(), EXACT), after)
    walk = propagated(nav._replace(covariance=np.zeros((SIZE, SIZE))), *readings(), EXACT).covariance
    assert after.covariance - walk == pytest.approx(np.outer(grown, grown), abs=2e-3 * STEP**2)


def test_readings_integrate_to_the_path_of_constant_force_and_rate() -> None:
    nav = example()._replace(gyroscope_bias=np.zeros(3), accelerometer_bias=np.zeros(3))
    rate = np.array([0.0, 0.0, 2.0])
    up = matrix(np.array([1.0, 0, 0, 0]))
    after = propagated(
        nav._replace(rotation=up),
        np.tile(rate, (200, 1)),
        np.tile([0, 0, 11.81], (200, 1)),
        np.full(200, 0.005),
        EXACT,
    )
    assert after.velocity - nav.velocity == pytest.approx(np.array([0, 0, 2.0]), abs=1e-9)
    assert after.position - nav.position - nav.velocity == pytest.approx(np.array([0, 0, 1.0]), abs=1e-9)
    assert after.rotation == pytest.approx(matrix(from_rotation_vector(rate)))
    assert after.acceleration == pytest.approx(np.array([0, 0, 2.0]))
    assert after.turn_rate == pytest.approx(rate)


@pytest.mark.parametrize("component", range(SIZE))
def test_jacobian_of_the_sight_is_that_of_its_position(component: int) -> None:
    nav, error = example(), np.eye(SIZE)[component] * STEP
    kept = nav._replace(turn_rate=np.zeros(3))  # how the arm's speed turns is left out
    slope = (
        predicted_position(moved(kept, error), 0.003).position - predicted_position(kept, 0.003).position
    ) / STEP
    assert predicted_position(kept, 0.003).jacobian[:, component] == pytest.approx(slope, abs=1e-4)


def test_sight_moves_with_velocity_turn_rate_and_acceleration() -> None:
    nav = example()
    now, later = predicted_position(nav, -nav.delay), predicted_position(nav, 0.01 - nav.delay)
    arm = nav.rotation @ nav.lever_arm
    assert now.position == pytest.approx(nav.position + arm)
    velocity = nav.velocity + np.cross(nav.turn_rate, arm)
    assert later.position == pytest.approx(now.position + 0.01 * velocity + 5e-5 * nav.acceleration)
    assert later.velocity == pytest.approx(velocity + 0.01 * nav.acceleration)


def test_correction_is_that_of_the_information_form() -> None:
    nav = example()
    predicted = predicted_position(nav, 0.003)
    found = corrected(nav, predicted, predicted.position + np.array([0.002, -0.001, 0.003]), NOISE, 6.0)
    H, P = predicted.jacobian, nav.covariance
    wanted = np.linalg.inv(np.linalg.inv(P) + H.T @ np.linalg.inv(NOISE) @ H)
    step = wanted @ H.T @ np.linalg.inv(NOISE) @ [0.002, -0.001, 0.003]
    assert away(found, nav) == pytest.approx(step, abs=1e-9)
    by = rotation_exp(step[ROTATION])
    along = np.eye(SIZE)
    along[ROTATION, ROTATION] = along[VELOCITY, VELOCITY] = along[POSITION, POSITION] = by
    assert found.covariance == pytest.approx(along @ wanted @ along.T, rel=1e-6, abs=1e-12)
    assert found.rejected == 0


def test_position_far_away_changes_nothing_but_the_count() -> None:
    nav = example()
    found = corrected(
        nav, predicted_position(nav, 0.0), predicted_position(nav, 0.0).position + 1.0, NOISE, 6.0
    )
    assert found.rejected == 1
    assert (away(found, nav) == 0).all()
    assert (found.covariance == nav.covariance).all()


def test_navigation_begins_and_is_doubted_with_the_covariance_of_the_position() -> None:
    place = np.array([1.0, 2.0, 3.0])
    for nav in (
        initiated(np.array([1.0, 0, 0, 0]), SIGMA, place, NOISE, EXACT),
        reinitiated(example(), place, NOISE),
    ):
        assert nav is not None
        predicted = predicted_position(nav, -nav.delay)
        assert predicted.position == pytest.approx(place)
        still = predicted_position(
            nav._replace(turn_rate=np.zeros_like(nav.velocity), acceleration=0 * nav.velocity),
            -nav.delay,
        )
        assert still.covariance == pytest.approx(NOISE, abs=1e-9)
        assert np.linalg.eigvalsh(nav.covariance).min() > -1e-12
        assert np.abs(nav.velocity).max() == 0


def test_coasting_grows_as_a_constant_unknown_acceleration() -> None:
    nav = example()._replace(covariance=np.zeros((SIZE, SIZE)))
    after = coasted(nav, 0.5)
    assert after.position == pytest.approx(nav.position + 0.5 * nav.velocity)
    assert np.sqrt(after.covariance[3, 3]) == pytest.approx(12.0 * 0.5)
    assert np.sqrt(after.covariance[0, 0]) == pytest.approx(3.0 * 0.5)
    assert (after.acceleration == 0).all()


@pytest.mark.parametrize("axis", range(3))
def test_bias_of_the_gyroscope_bends_the_path(axis: int) -> None:
    rates, forces = np.tile([0.02, -0.01, 0.03], (40, 1)) + example().gyroscope_bias, np.tile(FORCE, (40, 1))
    component, seconds = 9 + axis, 0.005
    error = np.eye(SIZE)[component] * STEP
    nav = example()._replace(covariance=np.outer(error, error))
    after = propagated(nav, rates, forces, np.full(40, seconds), EXACT)
    slope = away(propagated(moved(nav, error), rates, forces, np.full(40, seconds), EXACT), after) / STEP
    column = after.covariance[component] / STEP**2
    for part in (ROTATION, VELOCITY, POSITION):
        size = np.linalg.norm(slope[part])
        assert np.linalg.norm(column[part] - slope[part]) < 0.15 * size
        assert size > 1e-3


def test_noise_of_two_halves_of_a_step_is_that_of_the_step() -> None:
    densities = Densities(1.0, 2.0, 3.0, 4.0)
    whole, half = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    add_noise(whole, densities, 0.2)
    add_noise(half, densities, 0.1)
    F = np.eye(SIZE)
    F[POSITION, VELOCITY] = 0.1 * np.eye(3)
    halves = F @ half @ F.T
    add_noise(halves, densities, 0.1)
    assert halves == pytest.approx(whole)
    assert np.diagonal(whole)[[0, 3, 9, 12]] == pytest.approx([0.2, 0.4, 0.6, 0.8])


def test_errors_of_scale_grow_with_turn_rate_and_acceleration() -> None:
    errors = SensorErrors(2e-4, 4e-3, 0.002, 0.003, 0.02, 0.1, 0.03, 0.005)
    still = of_readings(np.zeros((4, 3)), np.zeros((4, 3)), errors)
    assert still.rotation == pytest.approx(4e-8)
    assert still.force == pytest.approx(1.6e-5)
    moving = of_readings(np.tile([0, 5.0, 0], (4, 1)), np.tile([0, 0, 20.0], (4, 1)), errors)
    assert moving.rotation == pytest.approx(4e-8 + (0.002 * 5) ** 2 * 0.2)
    assert moving.force == pytest.approx(1.6e-5 + (0.003 * 20) ** 2 * 0.2)
    assert moving.accelerometer_bias == pytest.approx(4e-8 + (0.003 * 9.81) ** 2 * 5)
    assert still.accelerometer_bias == pytest.approx(4e-8)
