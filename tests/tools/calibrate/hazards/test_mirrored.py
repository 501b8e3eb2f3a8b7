"""A camera whose picture is flipped: its epipolar lines are perfect, its place is not."""

from __future__ import annotations

import pytest
from tests.tools.calibrate.rooms import SIZE, MadeRoom, waved_room

from followspot.errors import FollowspotError
from followspot_calibrate.wand.solving import solve


@pytest.mark.parametrize(
    ("lenses", "axis", "way"),
    [
        ("known", 0, "left-right"),
        ("known", 1, "up-down"),
        pytest.param("unknown", 0, "left-right", marks=pytest.mark.thorough),
    ],
)
def test_the_mirrored_camera_and_the_way_are_named(lenses, axis, way):
    room = mirrored(waved_room(5, 300, missing=0.2, outliers=0.1), 2, axis)
    with pytest.raises(
        FollowspotError, match=f"^the picture of cam2 is mirrored {way}: .* switch mirroring off"
    ):
        solve(room.sightings, room.cameras if lenses == "known" else None)


@pytest.mark.thorough
def test_two_mirrored_cameras_are_both_named():
    room = mirrored(mirrored(waved_room(6, 300), 0, 0), 3, 0)
    with pytest.raises(FollowspotError) as raised:
        solve(room.sightings, room.cameras)
    told = [text.split(":")[0] for text in str(raised.value).splitlines()]
    assert told == [f"the picture of {name} is mirrored left-right" for name in ("cam0", "cam3")]


def test_the_mirrored_one_of_three_is_named():
    room = mirrored(waved_room(3, 300, outliers=0.1), 1, 0)
    with pytest.raises(FollowspotError, match="cam1 is mirrored left-right"):
        solve(room.sightings, room.cameras)


def mirrored(room: MadeRoom, camera: int, axis: int) -> MadeRoom:
    """The room with the pictures of one camera flipped along an axis."""
    room.sightings.pixel[:, camera, axis] = SIZE[axis] - 1 - room.sightings.pixel[:, camera, axis]
    return room
