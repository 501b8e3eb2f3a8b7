"""The bulb in recordings: sub-pixel, and rather not seen than mistaken for a reflection."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.rooms import made_room

from followspot import Room
from followspot.cli.main import main
from followspot.errors import InputError
from followspot.geometry import project
from followspot.room_file import load, save
from followspot_calibrate.wand.bulb import find_bulb

FRAMES = 60


@pytest.fixture(scope="module")
def room():
    """A room with small pictures, as a bulb is seen in them."""
    made = made_room(4, FRAMES, distortion=(0, 0, 0, 0, 0), seed=2)
    half = np.diag([0.5, 0.5, 1])
    cameras = [replace(c, size=(320, 240), matrix=half @ c.matrix) for c in made.cameras]
    return cameras, made.points


@pytest.fixture(scope="module")
def clips(room, tmp_path_factory):
    """Pictures of the bulb with a dim lamp that stands still; in frame 5 a reflection is as bright."""
    folder = tmp_path_factory.mktemp("clips")
    cameras, points = room
    for camera in cameras:
        (folder / camera.name).mkdir()
        for frame, place in enumerate(project(camera, points)):
            lights = [(place, 200), (np.array([40.0, 30.0]), 90)]
            if frame == 5:
                lights.append((place + np.array([0.0, 30.0]), 190))
            picture = np.clip(sum(spot(at, bright) for at, bright in lights), 0, 255)
            cv2.imwrite(str(folder / camera.name / f"{frame:04}.png"), picture.astype(np.uint8))
    return folder


def test_the_bulb_is_found_within_a_tenth_of_a_pixel(room, clips):
    cameras, points = room
    found = find_bulb(clips, cameras)
    exact = np.stack([project(camera, points) for camera in cameras], axis=1)
    inside = ((exact > 10) & (exact < np.array([310, 230]))).all(axis=2)
    inside[5] = False
    assert found.seen[inside].mean() > 0.95
    away = np.linalg.norm(found.pixel - exact, axis=2)[found.seen & inside]
    assert np.median(away) < 0.1


def test_a_reflection_as_bright_as_the_bulb_leaves_it_unseen(room, clips):
    assert not find_bulb(clips, room[0]).seen[5].any()


def test_recordings_become_a_room(room, clips, tmp_path):
    cameras = room[0]
    turned = {c.name: replace(c, rotation=np.eye(3), translation=-c.center) for c in cameras}
    save(Room("studio", turned), tmp_path / "room.yaml")
    arguments = ["--clips", str(clips), "--room", str(tmp_path / "room.yaml"), "--intrinsics", "known"]
    assert main(["calibrate", "wand", *arguments]) == 0
    for found, true in zip(load(tmp_path / "room.yaml").cameras.values(), cameras, strict=True):
        assert found.center == pytest.approx(true.center, abs=0.01)
        assert found.rotation == pytest.approx(true.rotation, abs=0.005)


def test_a_camera_without_recording_is_named(room, clips, tmp_path):
    (tmp_path / "cam0").symlink_to(clips / "cam0")
    with pytest.raises(InputError, match="no recording of cam1, cam2, cam3"):
        find_bulb(tmp_path, room[0])


def test_recordings_without_a_room_are_refused(clips, tmp_path, capsys):
    assert main(["calibrate", "wand", "--clips", str(clips), "-o", str(tmp_path / "new.yaml")]) == 2
    assert "--clips needs a room" in capsys.readouterr().err


def spot(at, brightness: float):
    rows, columns = np.indices((240, 320))
    return brightness * np.exp(-((columns - at[0]) ** 2 + (rows - at[1]) ** 2) / (2 * 1.6**2))
