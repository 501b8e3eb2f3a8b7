"""When navigation begins, and what becomes of one whose heading the search contradicts."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import Array
from followspot.rotation import from_rotation_vector
from followspot_balls.inertial.alignment import searched as search_after
from followspot_balls.inertial.alignment import with_navigation
from followspot_balls.inertial.fix import fix_at
from followspot_balls.inertial.frame_state import Frame, FrameState
from followspot_balls.inertial.heading import HeadingSearch, search_initiated
from followspot_balls.inertial.history import Rows, with_orientations
from followspot_balls.inertial.initiation import heading_difference, heading_sigma, initiated
from followspot_balls.inertial.navigation import Navigation
from followspot_balls.inertial.sensor_errors import SensorErrors

ERRORS = SensorErrors(2e-4, 4e-3, 0.002, 0.002, 0.02, 0.1, 0.03, 0.005)
PLACE, NOISE = np.array([1.0, 2.0, 1.5]), np.eye(3) * 1e-5
TIME = 1_000_000_000
LEVEL = np.array([0.02])
ROWS = Rows(
    np.array([TIME]), np.concatenate([np.zeros(5), [9.81], from_rotation_vector(np.zeros(3)), LEVEL])[None]
)


def searched(degrees: float, sigma: float) -> HeadingSearch:
    """A search that has found a heading with a sigma, both in degrees."""
    evidence = np.exp(1j * np.radians(degrees)) / np.radians(sigma) ** 2
    return search_initiated(TIME, PLACE, NOISE, 0j, 0.02, ERRORS)._replace(evidence=complex(evidence))


def headed(degrees: float) -> Array:
    return from_rotation_vector(np.array([0.0, 0.0, np.radians(degrees)]))


def frame_state(nav: Navigation | None) -> FrameState:
    return FrameState(Frame(TIME, (PLACE, NOISE)), nav, None, TIME, np.zeros(6))


def navigation(degrees: float) -> Navigation:
    return initiated(headed(degrees), np.full(3, 0.02), PLACE, NOISE, ERRORS)


@pytest.mark.parametrize(
    ("sigma", "begins", "ends"), [(20.0, False, False), (12.0, True, False), (4.0, True, True)]
)
def test_navigation_begins_at_the_heading_that_is_found(sigma: float, begins: bool, ends: bool) -> None:
    found = with_navigation(frame_state(None), searched(70.0, sigma), ROWS, ERRORS)
    assert (found.nav is not None, found.search is None) == (begins, ends)
    if found.nav is not None:
        assert heading_difference(found.nav, headed(70.0)) == pytest.approx(0.0, abs=1e-9)
        assert heading_sigma(found.nav) == pytest.approx(np.radians(sigma))


def test_navigation_far_from_the_heading_that_is_found_begins_anew() -> None:
    found = with_navigation(frame_state(navigation(50.0)), searched(70.0, 4.0), ROWS, ERRORS)
    assert found.nav is not None
    assert heading_difference(found.nav, headed(70.0)) == pytest.approx(0.0, abs=1e-9)
    assert heading_sigma(found.nav) == pytest.approx(np.radians(4.0))


def test_smaller_difference_from_the_heading_that_is_found_counts_as_uncertainty() -> None:
    nav = navigation(63.0)
    found = with_navigation(frame_state(nav), searched(70.0, 4.0), ROWS, ERRORS)
    assert found.nav is not None
    assert found.search is None
    assert (found.nav.rotation == nav.rotation).all()
    assert heading_sigma(found.nav) == pytest.approx(np.hypot(0.02, np.radians(7.0)))


def test_navigation_is_left_alone_until_the_search_ends() -> None:
    nav = navigation(50.0)
    found = with_navigation(frame_state(nav), searched(70.0, 6.0), ROWS, ERRORS)
    assert found.nav is nav
    assert found.search is not None


def test_orientation_is_told_once_the_search_is_sure_enough() -> None:
    vague, known = (
        fix_at(frame_state(navigation(50.0))._replace(search=searched(50.0, sigma)), TIME)
        for sigma in (11.0, 9.0)
    )
    assert vague is not None
    assert known is not None
    assert np.isnan(vague.quaternion).all()
    assert vague.xyz == pytest.approx(PLACE)
    assert known.quaternion == pytest.approx(headed(50.0))
    assert known.orientation_sigma == pytest.approx(np.radians(9.0))


def test_readings_are_levelled_where_both_are_known() -> None:
    readings = Rows(np.array([1, 2, 4]), np.arange(18.0).reshape(3, 6))
    orientations = Rows(np.array([2, 3, 4]), 100.0 + np.arange(15.0).reshape(3, 5))
    found = with_orientations(readings, orientations)
    assert found.time.tolist() == [2, 4]
    assert found.values[1].tolist() == [12, 13, 14, 15, 16, 17, 110, 111, 112, 113, 114]


def test_search_goes_on_from_the_first_reading_after_a_gap() -> None:
    search = searched(0.0, 4.0)
    time = TIME + np.array([200, 205]) * 1_000_000
    level = np.tile(from_rotation_vector(np.zeros(3)), (2, 1))
    forces = np.tile([10.0, -4.0, 9.81], (2, 1))
    rows = Rows(time, np.hstack([np.zeros((2, 3)), forces, level, np.full((2, 1), 0.02)]))
    found = search_after(search, Frame(int(time[-1]), None), rows, 0.05, ERRORS)
    assert found is not None
    assert found.states[1, 1] == pytest.approx((10.0 - 4.0j) * 0.005)
    assert found.read == time[-1]
    assert found.sigma > np.radians(20.0)
    later = search_after(
        found, Frame(int(time[-1]) + 300_000_000, None), rows.since(found.read), 0.05, ERRORS
    )
    assert later is not None
    assert later.sigma > found.sigma
