"""The search for the heading: a likelihood that is exact, learns from motion, and learns nothing at rest."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import Array
from followspot_balls.inertial.heading import (
    HeadingSearch,
    Steps,
    search_coasted,
    search_corrected,
    search_initiated,
    search_propagated,
)
from followspot_balls.inertial.sensor_errors import SensorErrors

ERRORS = SensorErrors(2e-4, 4e-3, 0.002, 0.002, 0.02, 0.1, 0.03, 0.005)
NOISE = np.eye(3) * 0.003**2
PERIOD = 1 / 60
PARTS = 4
"""Readings between two positions."""


def paths(seconds: float, size: float, seed: int = 0) -> tuple[Array, Array]:
    """Positions (N,) m as complex numbers, and forces (N - 1, PARTS) m/s^2 at the ends of the steps."""
    rng = np.random.default_rng(seed)
    rate, phase = rng.uniform(1.0, 4.0, (2, 3)), rng.uniform(0, 2 * np.pi, (2, 3))
    time = np.arange(round(seconds / PERIOD) * PARTS + 1)[:, None] * (PERIOD / PARTS)
    x, y = (size * np.sin(w * time + p) for w, p in zip(rate, phase, strict=True))
    ax, ay = (-size * w**2 * np.sin(w * time + p) for w, p in zip(rate, phase, strict=True))
    z, force = (x + 1j * y).sum(axis=1), (ax + 1j * ay).sum(axis=1)
    return z[::PARTS], force[1:].reshape(-1, PARTS)


def searched(
    z: Array,
    force: Array,
    heading: float,
    seed: int = 0,
    bias: complex = 0.0,
    inclination: float = 0.02,
    turn_rate: float = 0.5,
) -> HeadingSearch:
    """The search after noisy positions that are the path turned by the heading."""
    rng = np.random.default_rng((seed, 1))
    noise = NOISE[0, 0] ** 0.5 * (rng.normal(size=z.shape) + 1j * rng.normal(size=z.shape))
    seen = z * np.exp(1j * heading) + noise
    read = force + 0.03 * (rng.normal(size=force.shape) + 1j * rng.normal(size=force.shape)) + bias
    search = search_initiated(0, np.array([seen[0].real, seen[0].imag, 1.0]), NOISE, 0j, inclination, ERRORS)
    for frame, (place, part) in enumerate(zip(seen[1:], read, strict=True), 1):
        time = round(frame * PERIOD * 1e9)
        steps = Steps(time, np.full(PARTS, PERIOD / PARTS), part, np.full(PARTS, turn_rate), inclination)
        search = search_propagated(search, steps, ERRORS)
        search = search_corrected(search, time, np.array([place.real, place.imag, 1.0]), NOISE, 6.0)
    return search


def away(search: HeadingSearch, heading: float) -> float:
    """Error of the heading, rad."""
    return abs(float(np.angle(np.exp(1j * (search.heading - heading)))))


@pytest.mark.parametrize("heading", [-2.5, 0.4, 3.1])
def test_heading_is_learnt_from_motion_within_its_sigma(heading: float) -> None:
    errors = []
    for seed in range(6):
        search = searched(*paths(3.0, 0.1, seed), heading, seed, bias=0.05 - 0.08j)
        assert search.sigma < np.radians(5.0)
        errors.append(away(search, heading) / search.sigma)
    assert max(errors) < 3.0
    assert np.sqrt(np.mean(np.square(errors))) < 1.5


def test_nothing_is_learnt_at_rest_however_long() -> None:
    for seed in range(3):
        search = searched(*paths(30.0, 0.0), 1.0, seed, bias=0.06 + 0.03j)
        assert search.sigma > np.radians(20.0)


def test_vertical_motion_tells_no_heading_and_motion_along_one_axis_does() -> None:
    z, force = paths(3.0, 0.1, 2)
    assert searched(0 * z, 0 * force, 1.0).sigma > np.radians(20.0)
    line = searched(z.real + 0j, force.real + 0j, 1.0)
    assert line.sigma < np.radians(5.0)
    assert away(line, 1.0) < 3 * line.sigma


def test_wrong_inclination_and_an_unknown_lever_arm_make_the_heading_vaguer() -> None:
    sure = searched(*paths(3.0, 0.1), 1.0).sigma
    assert searched(*paths(3.0, 0.1), 1.0, inclination=0.2).sigma > 2.0 * sure
    assert searched(*paths(3.0, 0.1), 1.0, turn_rate=5.0).sigma > 1.3 * sure


def test_evidence_is_the_likelihood_of_a_filter_with_each_heading() -> None:
    """Against a filter of its own for each heading, which knows the readings: log p of the innovations."""
    z, force = paths(0.5, 0.1)
    search = search_initiated(0, np.array([z[0].real, z[0].imag, 0.0]), NOISE, 0j, 0.02, ERRORS)
    headings = np.array([0.3, 1.7, -2.0])
    state, log = np.zeros((3, 3), complex), np.zeros(3)
    state[0] = z[0] * np.exp(-1j * headings)
    for place, part in zip(z[1:], force, strict=True):
        steps = Steps(0, np.full(PARTS, PERIOD / PARTS), part, np.zeros(PARTS), 0.02)
        before, search = search, search_propagated(search, steps, ERRORS)
        gain = _gain(before, steps)
        kept = np.exp(-PERIOD / 3.0)
        F = np.array([[1, PERIOD, PERIOD**2 / 2], [0, 1, PERIOD], [0, 0, kept]])
        state = F @ state + gain[:, None]
        S = search.covariance[0, 0] + NOISE[0, 0]
        new = place * np.exp(-1j * headings) - state[0]
        log -= np.abs(new) ** 2 / (2 * S)
        state += np.outer(search.covariance[:, 0] / S, new)
        xyz = np.array([place.real, place.imag, 0.0])
        search = search_corrected(search, 0, xyz, NOISE, 1e9)
    found = np.real(np.exp(-1j * headings) * search.evidence)
    assert found - found[0] == pytest.approx(log - log[0], rel=0.02)


def _gain(search: HeadingSearch, steps: Steps) -> Array:
    """What the readings of a step add to position, velocity and error, (3,)."""
    still = search._replace(states=np.zeros((3, 2), complex))
    return search_propagated(still, steps, ERRORS).states[:, 1]


def test_heading_that_is_not_seen_for_a_while_is_forgotten() -> None:
    search = searched(*paths(3.0, 0.1), 1.0)
    shortly, long = (search_coasted(search, search.read + round(s * 1e9)) for s in (0.02, 0.5))
    assert search.sigma < shortly.sigma < np.radians(10.0)
    assert long.sigma > np.radians(60.0)
    assert shortly.heading == pytest.approx(search.heading)
    assert long.covariance[0, 0] > (0.5 * 12.0 * 0.5**2) ** 2 / 4


def test_false_position_is_rejected_whatever_the_heading() -> None:
    search = searched(*paths(3.0, 0.1), 1.0)
    far = search_corrected(search, search.read, np.array([5.0, 5.0, 1.0]), NOISE, 6.0)
    assert far.rejected == 1
    assert far.evidence == search.evidence
    assert (far.states == search.states).all()


def test_a_position_between_readings_is_compared_where_the_target_is_then() -> None:
    z, force = paths(3.0, 0.1)
    search = searched(z, force, 1.0)._replace(force=2.0 + 1.0j)
    search = search._replace(evidence=0j, states=np.array([[0, 0], [0.4, 0.3j], [0, 0]], complex))
    seconds = 0.004
    S = (
        np.array([1, seconds, seconds**2 / 2]) @ search.covariance @ [1, seconds, seconds**2 / 2]
        + NOISE[0, 0]
    )
    found = search_corrected(
        search, search.read + round(seconds * 1e9), np.array([0.01, 0.02, 0.0]), NOISE, 1e9
    )
    measured = 0.01 + 0.02j - 0.4 * seconds
    read = 0.3j * seconds + (2.0 + 1.0j) * seconds**2 / 2
    assert found.evidence == pytest.approx(measured * np.conj(read) / S)


def test_checkpoint_gives_the_search_back() -> None:
    search = searched(*paths(1.0, 0.1), 1.0)
    back = HeadingSearch.restored(search.plain())
    assert all(np.array_equal(a, b) for a, b in zip(search, back, strict=True))
