"""A camera that was moved halfway: which, when, how far; and what was recorded since still calibrates it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, wand_file, waved_room

from followspot import Camera, Room
from followspot.cli.main import main
from followspot.geometry import project
from followspot.room_file import load, save
from followspot_calibrate.adjust.projection import rotation_of
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.solving import solve

ROWS = 400


@pytest.mark.parametrize(
    ("degrees", "at"),
    [
        (0.3, 200),
        pytest.param(5.0, 120, marks=pytest.mark.thorough),
        pytest.param(30.0, 300, marks=pytest.mark.thorough),
    ],
)
def test_the_camera_and_the_frame_are_named(degrees, at):
    room, _ = with_move(waved_room(5, ROWS, missing=0.2), 1, degrees, at)
    told = warnings_of(solve(room.sightings, room.cameras, "known"))
    assert len(told) == 1
    head, frame = told[0].split(" was moved at frame ")
    assert head == "cam1"
    assert int(frame.split(",")[0]) == pytest.approx(at, abs=5)
    assert float(told[0].split(" by ")[1].split(" degrees")[0]) == pytest.approx(degrees, abs=0.15)


def test_reflections_do_not_hide_a_move():
    room, _ = with_move(waved_room(6, ROWS, outliers=0.2), 4, 3.0, 160)
    told = warnings_of(solve(room.sightings, room.cameras, "known"))
    assert told[0].startswith("cam4 was moved at frame 1")
    assert not any("cam4" in text for text in told[1:])


def test_two_moved_cameras_are_both_named():
    room, _ = with_move(waved_room(6, ROWS), 1, 2.0, 150)
    room, _ = with_move(room, 4, 2.0, 220)
    told = warnings_of(solve(room.sightings, room.cameras, "known"))
    named = sorted(text.split(",")[0] for text in told)
    assert named == ["cam1 was moved at frame 150", "cam4 was moved at frame 220"]


def test_of_three_cameras_one_is_named():
    room, _ = with_move(waved_room(3, ROWS), 2, 5.0, 150)
    told = warnings_of(solve(room.sightings, room.cameras, "known"))
    assert [text[:28] for text in told] == ["cam2 was moved at frame 150,"]


@pytest.mark.thorough
def test_frames_since_the_move_give_the_room_as_it_is_now(tmp_path, capsys):
    room, after = with_move(waved_room(5, ROWS), 3, 4.0, 200)
    path, points = tmp_path / "room.yaml", wand_file(room, tmp_path / "wand.csv")
    save(Room("studio", {camera.name: camera for camera in room.cameras}), path)
    arguments = ["calibrate", "wand", "--points", str(points), "--room", str(path)]
    assert main(arguments) == 0
    assert "cam3 was moved at frame 200" in capsys.readouterr().err
    assert main([*arguments, "--frames", "200-"]) == 0
    assert capsys.readouterr().err == ""
    assert load(path).cameras["cam3"].rotation == pytest.approx(after.rotation, abs=0.005)
    assert main([*arguments, "--frames", "900-950"]) == 2
    assert "there are 0-399" in capsys.readouterr().err


@pytest.mark.parametrize("frames", ["9-3", "-3", "all", "1-2-3"])
def test_frames_that_are_none_are_refused(frames, capsys):
    with pytest.raises(SystemExit):
        main(["calibrate", "wand", "--points", "wand.csv", f"--frames={frames}"])
    assert "write 0-349 or 350-" in capsys.readouterr().err


def with_move(room: MadeRoom, number: int, degrees: float, at: int) -> tuple[MadeRoom, Camera]:
    """The room with a camera turned and shifted from a frame on, and this camera."""
    before = room.cameras[number]
    rotation = rotation_of(np.radians(degrees) * np.array([0.3, 0.9, 0.3]) / np.sqrt(0.99)) @ before.rotation
    center = before.center + 0.02 * degrees * np.array([0.6, 0.8, 0.0])
    after = replace(before, rotation=rotation, translation=-rotation @ center)
    pixel = room.sightings.pixel
    rows = (np.arange(len(pixel)) >= at) & ~room.outlier[:, number]
    pixel[rows, number] += (project(after, room.points) - project(before, room.points))[rows]
    return room, after
