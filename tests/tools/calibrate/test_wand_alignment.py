"""From a frame of its own to the room's frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import made_room

from followspot.errors import FollowspotError, InputError
from followspot.geometry import project
from followspot_calibrate.similarity import Similarity
from followspot_calibrate.wand.alignment import Marker, onto_centers, onto_itself, onto_marker
from followspot_calibrate.wand.known_places import read_centers, read_marker

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
ROOM = made_room(cameras=5, rows=1)
CENTERS = {camera.name: camera.center for camera in ROOM.cameras}
NAMES = list(CENTERS)


def test_known_centres_undo_any_similarity():
    away = Similarity(TURN, np.array([1.0, 2.0, 3.0]), 2.5)
    found = onto_centers([away.camera(c) for c in ROOM.cameras], CENTERS, scaled=True)
    assert found.rms == pytest.approx(0, abs=1e-9)
    assert found.transform.scale == pytest.approx(1 / 2.5)
    assert found.warnings == ()


def test_a_wand_of_the_wrong_length_is_told():
    longer = Similarity(TURN, np.zeros(3), 1.25)
    found = onto_centers([longer.camera(c) for c in ROOM.cameras], CENTERS, scaled=False)
    assert found.transform.scale == 1
    assert "1.250 times those between the known places: check --length" in found.warnings[0]


def test_centres_that_fit_nothing_are_told():
    random = np.random.default_rng(0)
    shuffled = {name: center + random.normal(0, 1, 3) for name, center in CENTERS.items()}
    found = onto_centers(ROOM.cameras, shuffled, scaled=True)
    assert any("known places are met within" in text for text in found.warnings)


def test_flipped_pictures_of_all_cameras_are_told():
    cameras = made_room(cameras=6, rows=2).cameras
    known = {camera.name: camera.center for camera in cameras}
    flipped = [replace(c, translation=-c.rotation @ (c.center * [1.0, -1.0, 1.0])) for c in cameras]
    with pytest.raises(FollowspotError, match="v from the top"):
        onto_centers(flipped, known, scaled=True)
    known[cameras[0].name] = known[cameras[0].name] + 1.0
    with pytest.raises(FollowspotError, match="mirror image"):
        onto_centers(flipped, known, scaled=False)
    assert "was it moved?" in onto_centers(cameras, known, scaled=True).warnings[0]


def test_two_centres_are_too_few():
    with pytest.raises(FollowspotError, match="three are needed"):
        onto_centers(ROOM.cameras, dict(list(CENTERS.items())[:2]), scaled=True)


def test_a_marker_of_three_points_is_enough_and_two_are_not():
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    pixel = np.stack([project(camera, places) for camera in ROOM.cameras], axis=1)
    away = Similarity(TURN, np.array([1.0, 2.0, 3.0]), 0.5)
    cameras = [away.camera(camera) for camera in ROOM.cameras]
    found = onto_marker(cameras, Marker(places, pixel), scaled=True)
    assert found.transform.camera(cameras[0]).center == pytest.approx(CENTERS["cam0"], abs=1e-6)
    pixel[2, 1:] = np.nan
    with pytest.raises(FollowspotError, match="2 points of the marker"):
        onto_marker(cameras, Marker(places, pixel), scaled=True)


def test_without_anything_known_the_scale_is_said_to_be_unknown():
    assert "not metres" in onto_itself(ROOM.cameras, metric=False).warnings[0]
    assert onto_itself(ROOM.cameras, metric=True).warnings == ()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("camera,x,y,z\ncam9,0,0,0\n", "one of cam0, "),
        ("camera,x,y,z\ncam0,0,0,0\n0,0,0,0\n", "each camera once"),
        ("camera,x,y\ncam0,0,0\n", "missing columns: z"),
    ],
)
def test_a_wrong_file_of_centres_is_told(tmp_path, text, told):
    path = tmp_path / "centers.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=told):
        read_centers(path, NAMES)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x,y,z,camera,u,v\n", "has no points"),
        ("x,y,z,camera,u,v\n0,0,0,0,1,2\n0,0,0,cam0,1,2\n", "each camera once per point"),
        ("x,y,z,camera,u,v\n0,0,inf,0,1,2\n", "finite number"),
    ],
)
def test_a_wrong_marker_file_is_told(tmp_path, text, told):
    path = tmp_path / "marker.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=told):
        read_marker(path, NAMES)
