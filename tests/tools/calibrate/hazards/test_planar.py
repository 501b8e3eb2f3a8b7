"""Waving in a plane: refused where lenses have to be found, solved or refused where they are known."""

from __future__ import annotations

import numpy as np
import pytest
from tests.tools.calibrate.rooms import off_by, waved_room

from followspot.errors import FollowspotError
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.hazards.planar import flatness
from followspot_calibrate.wand.solving import solve

TABLE = (0.9, 0.9)
"""m: all points at one height."""


@pytest.mark.parametrize("height", [TABLE, (0.895, 0.905)])
def test_unknown_lenses_are_not_guessed_from_a_plane(height):
    room = waved_room(5, 300, height=height, outliers=0.1)
    with pytest.raises(
        FollowspotError, match=r"lie in one plane, from which unknown lenses .* wave up and down"
    ):
        solve(room.sightings, None)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.thorough)])
def test_known_lenses_in_a_plane_are_right_or_refused(seed):
    room = waved_room(4, 150, height=TABLE, seed=seed)
    try:
        solved = solve(room.sightings, room.cameras, "known")
    except FollowspotError as error:
        told = str(error)
    else:
        told = warnings_of(solved)[-1]
        assert off_by(solved.adjusted.cameras, room.cameras)[0].max() < 10
    assert told.startswith(("the points lie in one plane", "the points lie nearly in a plane"))


def test_five_centimetres_are_enough_for_known_lenses():
    room = waved_room(5, 300, height=(0.875, 0.925))
    solved = solve(room.sightings, room.cameras, "known")
    assert off_by(solved.adjusted.cameras, room.cameras)[0].max() < 10


def test_a_thin_layer_is_told_where_lenses_were_found():
    room = waved_room(6, 400, height=(0.85, 0.95))
    told = warnings_of(solve(room.sightings, None))
    assert "the points lie nearly in a plane, which leaves unknown lenses open" in told[-1]


def test_flatness_is_thickness_over_width():
    points = np.random.default_rng(0).uniform(-1, 1, (2000, 3)) * [2.0, 1.0, 0.1]
    assert flatness(points) == pytest.approx(0.1, abs=0.01)
    assert flatness(points * [1, 1, 0]) == 0
    assert flatness(np.full((5, 3), np.nan)) == 0
