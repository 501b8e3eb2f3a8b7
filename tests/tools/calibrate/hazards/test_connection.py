"""Cameras that see too little together: the groups, the pair and the number of points are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, off_by, waved_room

from followspot.errors import FollowspotError
from followspot.geometry import undistort
from followspot_calibrate.adjust import Free
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.incremental_sfm import reconstruct
from followspot_calibrate.wand.pairs import match
from followspot_calibrate.wand.solving import solve


@pytest.mark.parametrize("lenses", ["known", "unknown"])
def test_groups_without_a_common_view_are_named(lenses):
    room = waved_room(6, 300)
    together = np.isin(np.arange(6), [0, 2, 4])
    left = np.arange(300) < 150
    apart = seen_where(room, np.where(left[:, None], together, ~together))
    with pytest.raises(FollowspotError) as raised:
        solve(apart.sightings, room.cameras if lenses == "known" else None)
    told = str(raised.value).splitlines()
    assert told[0].startswith("the cameras fall into 2 groups")
    assert told[0].endswith(": cam0, cam2, cam4; cam1, cam3, cam5")
    assert "share 0 points, 30 needed: wave where both can see it" in told[1]


def test_a_pair_with_too_few_points_is_named():
    room = waved_room(4, 300)
    alone = np.ones((300, 4), bool)
    alone[11:, 3] = False
    with pytest.raises(FollowspotError, match=r"cam\d-cam3 share 11 points, 30 needed: wave"):
        solve(seen_where(room, alone).sightings, room.cameras, "known")


def test_frames_that_are_numbered_apart_are_told():
    room = waved_room(4, 200)
    late = seen_where(room, np.arange(4) == 3).sightings
    sightings = seen_where(room, np.arange(4) != 3).sightings
    both = replace(
        sightings,
        frame=np.concatenate([sightings.frame, late.frame + 5000]),
        label=np.concatenate([sightings.label, late.label]),
        pixel=np.concatenate([sightings.pixel, late.pixel]),
    )
    with pytest.raises(FollowspotError) as raised:
        solve(both, room.cameras, "known")
    told = str(raised.value).splitlines()
    assert told[0].startswith("the cameras fall into 2 groups")
    assert "has the frames 0 to 199, cam3 5000 to 5199: number the frames of all cameras from one" in told[1]


def test_a_camera_without_points_is_told():
    room = seen_where(waved_room(4, 200), np.arange(4) != 3)
    with pytest.raises(FollowspotError, match="cam3 has no points at all: wave in its view; is it in"):
        solve(room.sightings, room.cameras, "known")


def test_a_camera_that_was_recorded_at_half_the_size_is_told():
    room = waved_room(4, 200)
    room.sightings.pixel[:, 2] = room.sightings.pixel[:, 2] / 2
    with pytest.raises(FollowspotError, match=r"points of cam2 fit .* of 640x480 px only: was it"):
        solve(room.sightings, room.cameras, "known")


def test_a_place_by_chance_of_a_camera_of_half_the_size_is_warned_about():
    """Three cameras and 150 points leave the wrong lens room for a place."""
    room = waved_room(3, 150, seed=1)
    room.sightings.pixel[:, 2] = room.sightings.pixel[:, 2] / 2
    told = warnings_of(solve(room.sightings, room.cameras, "known"))
    assert any("the points of cam2 reach" in one and "at another size" in one for one in told)


def test_a_camera_of_another_recording_is_not_told_to_wave():
    room, other = waved_room(5, 200), waved_room(5, 200, seed=7)
    room.sightings.pixel[:, 4] = other.sightings.pixel[:, 4]
    with pytest.raises(FollowspotError, match="cam4") as raised:
        solve(room.sightings, room.cameras, "known")
    assert "wave where" not in str(raised.value)


def test_cameras_in_a_chain_are_placed_though_its_ends_share_nothing():
    room = waved_room(7, 700)
    first = np.arange(700) // 20 % 5
    near = (np.arange(7) >= first[:, None]) & (np.arange(7) < first[:, None] + 3)
    solved = solve(seen_where(room, near).sightings, room.cameras, "known")
    assert off_by(solved.adjusted.cameras, room.cameras)[0].max() < 25
    assert solved.timed.late.tolist() == [0] * 7


def test_two_cameras_that_see_most_alone_are_not_the_beginning_of_a_room():
    room = waved_room(4, 300)
    alone = np.arange(300) < 230
    pixel = seen_where(room, np.where(alone[:, None], [1, 1, 0, 0], [0, 1, 1, 1]) == 1).sightings.pixel
    limit = np.full(4, 6.0)
    straight = np.stack([undistort(c, pixel[:, i]) for i, c in enumerate(room.cameras)], axis=1)
    reconstruction = reconstruct(room.cameras, pixel, match(straight, limit), Free())
    assert reconstruction is not None
    assert sorted(reconstruction.placed) == [1, 2, 3]


def seen_where(room: MadeRoom, seen) -> MadeRoom:
    pixel = np.where(seen[..., None], room.sightings.pixel, np.nan)
    return replace(room, sightings=replace(room.sightings, pixel=pixel))
