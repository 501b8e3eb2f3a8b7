"""Particles of poses: how they move, their limits, how they are drawn anew, and their estimate."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.drawn import standing
from tests.plugins.persons.particles import EYE, crowd, rng

from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT
from followspot_persons.particles.condensation import MODE, Search, condense, estimated, scattered, systematic
from followspot_persons.particles.motion import HIGHEST, LOWEST, MAX_PAN, MAX_TILT, limited, predicted


def test_necks_and_heights_have_limits():
    extreme = np.array([[0, 0, 9, 0, 3, 3], [0, 0, -9, 0, -3, -3.0]])
    assert limited(extreme.copy())[:, [HEIGHT, PAN, TILT]].tolist() == [
        [HIGHEST, MAX_PAN, MAX_TILT],
        [LOWEST, -MAX_PAN, -MAX_TILT],
    ]


def test_motion_keeps_the_limits():
    after = predicted(crowd([2, 0, HIGHEST, 0, MAX_PAN, MAX_TILT], 500), np.zeros(2), 0.5, EYE, rng())
    assert after[:, HEIGHT].max() <= HIGHEST
    assert after[:, PAN].max() <= MAX_PAN
    assert after[:, TILT].max() <= MAX_TILT


def test_particles_move_on_and_spread_more_along_the_line_of_sight_than_across():
    after = predicted(crowd(standing(3.0), 4000), np.array([0.5, -1.0]), 0.2, EYE, rng())
    assert after[:, :2].mean(axis=0) == pytest.approx([3.1, -0.2], abs=0.02)
    along, across = after[:, :2].std(axis=0)
    assert along == pytest.approx(1.5 * across, rel=0.1)


def test_some_particles_turn_much_faster_than_most():
    turned = np.abs(predicted(crowd(standing(3.0), 4000), np.zeros(2), 0.1, EYE, rng())[:, HEADING] - np.pi)
    assert 0.02 < (turned > 0.5).mean() < 0.1
    assert np.median(turned) < 0.12


def test_a_share_of_the_particles_gets_another_heading():
    def level(pose):
        return np.zeros(len(pose))

    away = {}
    for share in (0.0, 0.3):
        after, _ = condense(
            crowd(standing(3.0, heading=0.0), 300), np.zeros(2), 0.0, level, EYE, Search(300, share, 0), rng()
        )
        away[share] = (np.cos(after[:, HEADING]) < 0).mean()
    assert away[0.0] == 0
    assert away[0.3] == pytest.approx(0.3 * (1 / 3 + 2 / 3 / 2), abs=0.04)


def test_a_third_of_the_scattered_is_turned_by_half_a_turn():
    scattering = scattered(crowd(standing(3.0, heading=0.3), 300), rng())
    np.testing.assert_allclose(scattering[:100, HEADING], 0.3 + np.pi)
    assert np.ptp(scattering[100:, HEADING]) > 6
    assert np.ptp(scattering[:200, :2], axis=0).tolist() == [0, 0]
    assert (scattering[200:, :2].std(axis=0) > 0.1).all()


def test_particles_are_drawn_as_often_as_they_weigh():
    weight = np.array([0.1, 0.0, 0.55, 0.35])
    drawn_rows = np.bincount(systematic(weight, 1000, rng()), minlength=4)
    assert np.abs(drawn_rows - 1000 * weight).max() <= 1


def test_an_estimate_lies_in_one_of_two_headings_and_not_between():
    cloud = crowd(standing(3.0), 100)
    cloud[:60, HEADING], cloud[60:, HEADING] = 0.2, 0.2 + np.pi
    pose = estimated(cloud, np.full(100, 0.01)).pose
    assert pose[HEADING] == pytest.approx(0.2)
    assert np.pi / 6 < MODE < np.pi / 2
