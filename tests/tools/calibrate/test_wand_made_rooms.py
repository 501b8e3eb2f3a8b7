"""`calibrate wand` in rooms made up for it: any number of cameras, missing points, outliers, chains, rods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.tools.calibrate.rooms import MadeRoom, made_room
from tests.tools.calibrate.wand_errors import FREE_MM, KNOWN_MM, NOISE, differences, similar

from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.solving import solve


@pytest.mark.parametrize(
    ("cameras", "missing", "outliers"),
    [(3, 0.1, 0.0), (4, 0.4, 0.1), (6, 0.6, 0.3), pytest.param(24, 0.5, 0.3, marks=pytest.mark.thorough)],
)
def test_known_intrinsics_give_the_room_within_noise(cameras, missing, outliers):
    room = made_room(cameras, 400, missing=missing, outliers=outliers, noise=NOISE)
    solved = solve(room.sightings, room.cameras, "known")
    millimetres, degrees = differences(solved, room)
    assert millimetres.max() < KNOWN_MM
    assert degrees.max() < 0.2
    assert (solved.adjusted.used & room.outlier).mean() < 0.005


@pytest.mark.parametrize(
    ("cameras", "missing", "outliers"),
    [(3, 0.1, 0.1), (6, 0.6, 0.2), pytest.param(9, 0.3, 0.3, marks=pytest.mark.thorough)],
)
def test_unknown_intrinsics_are_found_too(cameras, missing, outliers):
    room = made_room(cameras, 400, missing=missing, outliers=outliers, noise=NOISE)
    solved = solve(room.sightings, None)
    assert differences(solved, room)[0].max() < FREE_MM
    for found, true in zip(solved.adjusted.cameras, room.cameras, strict=True):
        assert found.matrix[0, 0] == pytest.approx(true.matrix[0, 0], rel=0.03)
    assert np.nanmedian(solved.adjusted.distance) < 1.2 * NOISE


@given(
    cameras=st.integers(3, 6),
    missing=st.floats(0.1, 0.5),
    outliers=st.floats(0.0, 0.2),
    seed=st.integers(0, 99),
)
@settings(max_examples=5, deadline=None)
def test_any_room_is_found_within_noise(cameras, missing, outliers, seed):
    room = made_room(cameras, 300, missing=missing, outliers=outliers, noise=NOISE, seed=seed)
    assert differences(solve(room.sightings, room.cameras, "known"), room)[0].max() < 2 * KNOWN_MM


def test_cameras_without_a_common_view_are_linked_in_a_chain():
    """Every point is seen by three neighbours of eight cameras; first and last have none in common."""
    room = made_room(8, 800, noise=NOISE)
    first = np.arange(800) % 6
    near = (np.arange(8) >= first[:, None]) & (np.arange(8) < first[:, None] + 3)
    solved = solve(seen_where(room, near), room.cameras, "known")
    assert differences(solved, room)[0].max() < 4 * KNOWN_MM


@pytest.mark.thorough
def test_auto_keeps_good_intrinsics_and_mends_bad_ones():
    room = made_room(5, 250, noise=NOISE)
    assert solve(room.sightings, room.cameras, "auto").intrinsics == "known"
    bad = [replace(c, distortion=np.zeros(5)) for c in room.cameras]
    mended = solve(room.sightings, bad, "auto")
    assert mended.intrinsics == "refined"
    assert differences(mended, room)[0].max() < FREE_MM


def test_a_wand_of_two_bulbs_gives_metres():
    room, sightings = with_two_bulbs(0.5)
    solved = solve(sightings, room.cameras, "known", 0.5)
    assert similar(solved, room).scale == pytest.approx(1.0, abs=0.001)
    doubled = solve(sightings, room.cameras, "known", 1.0)
    assert similar(doubled, room).scale == pytest.approx(0.5, abs=0.001)


def test_a_length_without_two_bulbs_is_refused():
    room = made_room(4, 100)
    with pytest.raises(FollowspotError, match="0 have both, 10 needed"):
        solve(room.sightings, room.cameras, "known", 0.5)


@pytest.mark.parametrize("cameras", [1, 3])
def test_points_that_no_two_cameras_saw_are_told(cameras):
    room = made_room(cameras, 60)
    first = np.broadcast_to(np.arange(cameras) == 0, (60, cameras))
    with pytest.raises(FollowspotError, match="wave"):
        solve(seen_where(room, first), None)


def test_two_cameras_with_known_lenses_are_enough():
    room = made_room(2, 200, noise=NOISE)
    found = solve(room.sightings, room.cameras, "known").adjusted
    relative = found.cameras[1].rotation @ found.cameras[0].rotation.T
    true = room.cameras[1].rotation @ room.cameras[0].rotation.T
    assert relative == pytest.approx(true, abs=0.005)


def test_two_groups_tied_by_one_camera_need_three_views():
    """Pairs alone leave the scale between the groups open."""
    room = made_room(5, 400, noise=NOISE)
    left = np.arange(400) < 200
    seen = np.where(left[:, None], [1, 1, 1, 0, 0], [0, 0, 1, 1, 1]).astype(bool)
    with pytest.raises(FollowspotError, match=r"shares 0 points with two of .* wave where three cameras"):
        solve(seen_where(room, seen), room.cameras, "known")


def test_a_camera_full_of_reflections_is_named():
    room = made_room(5, 250, noise=NOISE)
    pixel = room.sightings.pixel.copy()
    pixel[::3, 2] = np.random.default_rng(0).uniform([0, 0], [640, 480], pixel[::3, 2].shape)
    told = warnings_of(solve(replace(room.sightings, pixel=pixel), room.cameras, "known"))
    assert len(told) == 1
    assert "of the points of cam2 fit no other camera" in told[0]


def seen_where(room: MadeRoom, seen):
    return replace(room.sightings, pixel=np.where(seen[..., None], room.sightings.pixel, np.nan))


def with_two_bulbs(length: float):
    room = made_room(4, 200)
    random = np.random.default_rng(3)
    along = random.normal(size=room.points.shape)
    other = room.points + length * along / np.linalg.norm(along, axis=1, keepdims=True)
    ends = np.concatenate([room.points, other])
    pixel = np.stack([project(camera, ends) for camera in room.cameras], axis=1)
    pixel += random.normal(0, NOISE, pixel.shape)
    given = room.sightings
    frame, label = np.tile(given.frame, 2), np.repeat([0, 1], 200)
    return room, Sightings(given.cameras, given.sizes, frame, label, pixel)
