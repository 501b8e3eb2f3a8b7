"""Cameras that are not synchronised: found from the motion, told in frames and ms, corrected, noted."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.rooms import camera_of, off_by, wand_file, waved_room

from followspot import Room
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.room_file import load, save
from followspot_calibrate.adjust import Free
from followspot_calibrate.points_file import read_points
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.rounds import NothingFits, adjust_robustly
from followspot_calibrate.wand.solving import solve
from followspot_calibrate.wand.timing import Timed, with_offsets

WITHIN = 0.05
"""Frames: 0.3 px at 6 px a frame, less than the noise of 0.4 px."""
PLACE_MM = 8.0


@pytest.mark.parametrize(
    "late",
    [0.4, pytest.param(-1.5, marks=pytest.mark.thorough), pytest.param(37.3, marks=pytest.mark.thorough)],
)
def test_a_late_camera_is_told_and_corrected(late):
    room = waved_room(5, 300, late={4: late}, missing=0.1)
    solved = solve(room.sightings, room.cameras, "known")
    assert solved.timed.late == pytest.approx([0, 0, 0, 0, late], abs=WITHIN)
    assert solved.timed.late[:4].tolist() == [0, 0, 0, 0]
    assert off_by(solved.adjusted.cameras, room.cameras)[0].max() < PLACE_MM
    told = warnings_of(solved, fps=30.0)
    assert len(told) == 1
    frames = (
        f"cam4 is {abs(solved.timed.late[4]):.2f} frames ({1000 * abs(solved.timed.late[4]) / 30:.1f} ms)"
    )
    assert told[0].startswith(frames + (" late" if late > 0 else " early"))


@pytest.mark.thorough
def test_every_camera_may_have_been_started_by_hand():
    late = np.array([4.3, -3.0, 17.0, 40.6, 0.0])
    room = waved_room(5, 250, late=dict(enumerate(late)), missing=0.2, outliers=0.1)
    solved = solve(room.sightings, room.cameras, "known")
    found = solved.timed.late
    assert found - found[4] == pytest.approx(late - late[4], abs=WITHIN)
    assert off_by(solved.adjusted.cameras, room.cameras)[0].max() < PLACE_MM


def test_a_camera_that_has_no_place_as_it_is_finds_one_once_its_track_is_shifted():
    late = np.array([2.5, 0.0, -2.0])
    room = waved_room(3, 250, late=dict(enumerate(late)))
    found = solve(room.sightings, room.cameras, "known").timed.late
    assert found - found[1] == pytest.approx(late, abs=WITHIN)


def test_cameras_that_agree_on_nothing_are_refused():
    room = waved_room(4, 60)
    alone = np.arange(60)[:, None] % 4 == np.arange(4)
    with pytest.raises(NothingFits, match="no two cameras agree on any point"):
        adjust_robustly(room.cameras, np.where(alone[..., None], room.sightings.pixel, np.nan), Free())


@pytest.mark.parametrize(("camera", "late"), [(1, 4.5), (2, -6.0)])
def test_motion_that_tells_too_little_is_no_reason_to_fail(camera, late):
    """With unknown lenses a fifth of reflections and a third of gaps leave some points undetermined."""
    room = waved_room(5, 150, late={camera: late}, missing=0.3, outliers=0.2)
    found, refused = np.full(5, np.nan), ""
    try:
        found = solve(room.sightings, None).timed.late
    except FollowspotError as error:
        refused = str(error)
    assert "is it synchronised" in refused or abs(found[camera] - late) < 1


def test_unknown_lenses_do_not_hide_a_late_camera():
    room = waved_room(5, 250, late={1: 2.5}, outliers=0.1)
    solved = solve(room.sightings, None)
    assert solved.timed.late == pytest.approx([0, 2.5, 0, 0, 0], abs=WITHIN)


def test_two_cameras_tell_their_difference():
    room = waved_room(2, 400, late={1: 6.0})
    found = solve(room.sightings, room.cameras, "known").timed.late
    assert found[1] - found[0] == pytest.approx(6, abs=0.1)


@pytest.mark.parametrize("seed", [1, pytest.param(3, marks=pytest.mark.thorough)])
def test_a_camera_that_lost_frames_is_told_to_have(seed):
    room, shifted = waved_room(4, 300, seed=seed), waved_room(4, 300, late={3: 2.0}, seed=seed)
    room.sightings.pixel[150:, 3] = shifted.sightings.pixel[150:, 3]
    told = warnings_of(solve(room.sightings, room.cameras, "known"))
    assert any("cam3 comes" in text and "it lost frames" in text for text in told)


def test_the_offset_is_noted_in_the_room_file(tmp_path, capsys):
    room = waved_room(4, 300, late={2: 1.5})
    path, points = tmp_path / "room.yaml", wand_file(room, tmp_path / "wand.csv")
    save(Room("studio", {camera.name: camera for camera in room.cameras}), path)
    arguments = ["calibrate", "wand", "--points", str(points), "--room", str(path), "--json"]
    assert main([*arguments, "--fps", "30", "--clock-offsets"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["late_frames"]["cam2"] == pytest.approx(1.5, abs=WITHIN)
    assert "cam2 is 1.5" in told.err
    offsets = [camera.clock_offset for camera in load(path).cameras.values()]
    assert offsets == pytest.approx([0, 0, 0.05, 0], abs=WITHIN / 30)


def test_an_offset_that_no_room_file_takes_is_refused():
    room, late = waved_room(4, 300), np.array([0.0, 0, -60, 0])
    timed = Timed(room.sightings, late, np.zeros(4))
    with pytest.raises(FollowspotError, match=r"cam2 is -2\.00 s late, at most 1 s"):
        with_offsets(room.cameras, timed, 30.0)


@pytest.mark.thorough
@needs_data("selfcal-ball-9cam")
def test_real_cameras_out_of_step_fit_better_once_that_is_corrected():
    """selfcal-ball-9cam, a ball at 15 px a frame: without the correction the median is 2.7 px."""
    folder = dataset("selfcal-ball-9cam")
    rough = json.loads((folder / "intrinsics_initial.json").read_text())
    lenses = [camera_of(f"cam{i}", (1280, 800), rough[str(i)]) for i in range(9)]
    sightings = read_points(folder / "single_ball.npz", lenses, confidence=0.5).rows(slice(3000, 3300))
    solved = solve(sightings, lenses, "known")
    assert solved.timed.late[3] == pytest.approx(0.36, abs=0.1)
    assert np.nanmedian(solved.adjusted.distance) < 2.3


@pytest.mark.parametrize(
    ("arguments", "told"), [(["--clock-offsets"], "give --fps"), (["--fps", "-1"], "no frame rate")]
)
def test_arguments_about_clocks_are_checked(arguments, told, tmp_path, capsys):
    points = wand_file(waved_room(3, 40), tmp_path / "wand.csv")
    always = ["calibrate", "wand", "--points", str(points), "-o", str(tmp_path / "room.yaml")]
    assert main([*always, *arguments]) == 2
    assert told in capsys.readouterr().err
