"""Limits of space: where nobody can be, nobody is placed."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.drawn import standing
from tests.plugins.persons.shown import FastInstance, SlowInstance, numbers

from followspot_persons.likelihood.walkable import SIGMA, Walkable

CORNERS = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize("corners", [CORNERS, CORNERS[::-1], (*CORNERS, (1.0, 0.5))])
def test_places_beyond_the_convex_hull_are_as_far_outside_as_the_nearest_edge(corners):
    space = Walkable.within(corners)
    places = np.array([[1.0, 0.5], [2.0, 1.0], [2.3, 0.5], [1.0, -0.4], [-0.2, 0.5]])
    np.testing.assert_allclose(space.outside(places), [0, 0, 0.3, 0.4, 0.2], atol=1e-6)
    np.testing.assert_allclose(space.log_prior(places)[2], -0.5 * (0.3 / SIGMA) ** 2, rtol=1e-4)
    assert space.excludes(places[2:])
    assert not space.excludes(places)


def test_without_corners_people_can_be_everywhere():
    assert Walkable.within(()) is None


WALL = [(0.0, -2.0), (2.2, -2.0), (2.2, 2.0), (0.0, 2.0)]


@pytest.mark.parametrize(("corners", "distance"), [([], 2.5), (WALL, 2.25)])
def test_who_seems_to_be_behind_a_wall_is_before_it(corners, distance):
    room = FastInstance(walkable=corners, particles=200)
    room.tell(standing(2.5))
    for _ in range(8):
        poses = room.see(standing(2.5))
    assert poses.xy[0, 0] == pytest.approx(distance, abs=0.12)


@pytest.mark.parametrize(("corners", "away", "known"), [([], 4.5, [1]), (WALL, 4.5, []), (WALL, 2.0, [1])])
def test_boxes_where_nobody_can_be_initiate_nobody(corners, away, known):
    show = SlowInstance(grounded=True, walkable=corners)
    for _ in range(3):
        told = show.see(standing(away))
    assert numbers(told) == known
