"""Two cameras exchanged: their lenses, their places or the size of their pictures tell."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.tools.calibrate.rooms import MadeRoom, made_room, wand_file, waved_room

from followspot import Camera, Room
from followspot.cli.main import main
from followspot.errors import FollowspotError, InputError
from followspot.room_file import save
from followspot_calibrate.points_file import read_points
from followspot_calibrate.wand.alignment import onto_centers
from followspot_calibrate.wand.solving import solve


@pytest.mark.parametrize(
    ("intrinsics", "zoom"),
    [
        pytest.param("known", 1.15, marks=pytest.mark.thorough),
        pytest.param("auto", 1.3, marks=pytest.mark.thorough),
        ("known", 2.5),
    ],
)
def test_lenses_that_belong_to_each_other_name_the_two(intrinsics, zoom):
    room = waved_room(5, 200, missing=0.1, zooms={1: zoom})
    lenses = list(room.cameras)
    lenses[1], lenses[3] = lens_of(lenses[1], lenses[3]), lens_of(lenses[3], lenses[1])
    with pytest.raises(FollowspotError, match=r"^cam1 and cam3 are exchanged: .* exchange their recordings"):
        solve(room.sightings, lenses, intrinsics)


@pytest.mark.parametrize("cameras", [4, 6])
def test_known_centres_name_the_two(cameras):
    room = made_room(cameras, 1)
    centers = {camera.name: camera.center for camera in room.cameras}
    found = list(room.cameras)
    found[0], found[2] = replace(found[2], name="cam0"), replace(found[0], name="cam2")
    with pytest.raises(FollowspotError, match="cam0 and cam2 are exchanged: each is at the known place"):
        onto_centers(found, centers, scaled=True)


def test_exchanged_recordings_of_equal_cameras_are_told_and_nothing_is_written(tmp_path, capsys):
    room = swapped(waved_room(5, 200), 0, 3)
    path = tmp_path / "room.yaml"
    cameras = {camera.name: replace(camera, matrix=room.cameras[0].matrix) for camera in room.cameras}
    save(Room("studio", cameras), path)
    before = path.read_text()
    points = wand_file(room, tmp_path / "wand.csv")
    assert main(["calibrate", "wand", "--points", str(points), "--room", str(path)]) == 1
    assert "cam0 and cam3 are exchanged" in capsys.readouterr().err
    assert path.read_text() == before


def test_pictures_of_another_size_name_the_two(tmp_path):
    """cam0 has pictures half as large as cam2, in which points of cam2 have no room."""
    room = waved_room(4, 60)
    room.sightings.pixel[:, 0] /= 2
    cameras = [replace(room.cameras[0], size=(320, 240)), *room.cameras[1:]]
    points = wand_file(room, tmp_path / "wand.csv")
    assert read_points(points, cameras).seen.all()
    wand_file(swapped(room, 0, 2), points)
    with pytest.raises(InputError, match="cam0 and cam2 see points beyond their pictures"):
        read_points(points, cameras)


def swapped(room: MadeRoom, one: int, other: int) -> MadeRoom:
    """The room with what two cameras saw exchanged."""
    pixel = room.sightings.pixel
    pixel[:, [one, other]] = pixel[:, [other, one]]
    return room


def lens_of(camera: Camera, other: Camera) -> Camera:
    return replace(camera, matrix=other.matrix, distortion=other.distortion)
