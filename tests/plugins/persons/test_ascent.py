"""Gradient ascent of particles, one coordinate after the other."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.drawn import perspective, standing
from tests.plugins.persons.particles import EYE, crowd, rng

from followspot.geometry import project
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT
from followspot_persons.particles.ascent import ACROSS, DISTANCE, STATURE, STEPS, ascend, moved
from followspot_persons.particles.condensation import Search, condense
from followspot_persons.particles.motion import MAX_PAN, MAX_TILT, limited


@pytest.mark.parametrize("step", [-0.3, 0.3])
@pytest.mark.parametrize("height", [1.5, 1.9])
def test_ascent_along_the_distance_keeps_the_top_of_the_head_in_its_place_of_the_picture(step, height):
    camera = perspective()
    pose = standing(3.0, 0.4, height)[None]
    farther = moved(pose, camera.center, DISTANCE, step)
    top = project(camera, np.concatenate([pose, farther])[:, :3])
    np.testing.assert_allclose(top[1], top[0], atol=1e-9)
    apart = np.hypot(*farther[0, :2]) - np.hypot(*pose[0, :2])
    assert apart == pytest.approx(step)
    assert (farther[0, HEIGHT] - height) * (height - 1.2) * step > 0


def test_ascent_across_the_line_of_sight_keeps_distance_and_height():
    pose = np.array([[3.0, 4.0, 1.7, 1, 0, 0]])
    moved_left = moved(pose, EYE, ACROSS, 0.1)
    assert moved_left[0, :2] == pytest.approx([3 - 0.08, 4 + 0.06])
    assert moved_left[0, HEIGHT] == 1.7


def test_ascent_of_the_height_and_of_angles_changes_nothing_else():
    pose = standing(3.0)[None]
    for coordinate in (HEADING, PAN, TILT):
        changed = np.flatnonzero(moved(pose, EYE, coordinate, 0.1) - pose)
        assert changed.tolist() == [coordinate]
    assert STATURE == HEIGHT
    assert np.flatnonzero(moved(pose, EYE, STATURE, 0.1) - pose).tolist() == [HEIGHT]


def test_ascent_keeps_the_limits():
    pose = np.array([[2, 0, 1.7, 0, MAX_PAN, MAX_TILT]])
    for coordinate in STEPS:
        np.testing.assert_array_equal(
            moved(pose, EYE, coordinate, 1.0), limited(moved(pose, EYE, coordinate, 1.0))
        )


def test_each_coordinate_climbs_and_none_ever_descends():
    top = np.array([3.0, 0.0, 1.7, 1.0, 0.2, 0.1])

    def hill(pose):
        return -(((pose - top) / [1, 1, 1, 4, 4, 4]) ** 2).sum(axis=1)

    start = top + rng().normal(0, 0.2, (30, 6))
    before = hill(start)
    after, value = ascend(start, before, hill, EYE, 3)
    np.testing.assert_allclose(value, hill(after))
    assert (value >= before).all()
    assert np.median(value / before) < 0.5


def test_a_share_of_the_best_particles_climbs():
    asked = []

    def level(pose):
        asked.append(len(pose))
        return pose[:, 0].copy()

    condense(crowd(standing(3.0), 100), np.zeros(2), 0.1, level, EYE, Search(100, 0.1, 0.2), rng())
    assert asked == [100] + [2 * 20] * len(STEPS)
