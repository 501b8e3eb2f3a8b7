"""`calibrate wand --targets`: clips of single targets as more points, far more exact ones."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, made_room

from followspot import Room
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.messages import Array
from followspot.room_file import load, save
from followspot_calibrate.similarity import similarity
from followspot_calibrate.target_sightings import TargetSightings, find_target_sightings
from followspot_calibrate.wand.alignment import onto_centers
from followspot_calibrate.wand.solving import Solved, solve
from followspot_calibrate.wand.targets import noise, with_targets

FRAMES = 8
WIDTH = 10
"""Of a target in the clips, px."""


@pytest.fixture(scope="module")
def made() -> MadeRoom:
    """Six cameras and a wand whose points are off by a pixel."""
    return made_room(6, 200, noise=1.0)


@pytest.fixture(scope="module")
def solved(made: MadeRoom) -> Solved:
    return solve(made.sightings, list(made.cameras), "known")


def shown(made: MadeRoom, rows: int, noise: float) -> tuple[Array, Array]:
    """Places of targets, (N, 3) m, and what the cameras see of them."""
    random = np.random.default_rng(8)
    points = random.uniform([-1.2, -1.2, 0.2], [1.2, 1.2, 1.6], (rows, 3))
    exact = np.stack([project(camera, points) for camera in made.cameras], axis=1)
    return points, exact + random.normal(0, 1, exact.shape) * noise


def farthest_off(cameras, made: MadeRoom) -> float:
    """Of all the room's points in all pictures, px, once the centres are aligned."""
    target = np.array([camera.center for camera in made.cameras])
    move = similarity(np.array([camera.center for camera in cameras]), target)
    away = [
        np.linalg.norm(project(move.camera(found), made.points) - project(true, made.points), axis=1)
        for found, true in zip(cameras, made.cameras, strict=True)
    ]
    return float(np.max(away))


def test_a_hundred_exact_places_of_targets_improve_on_the_wand(made: MadeRoom, solved: Solved) -> None:
    refined = with_targets(solved, TargetSightings(shown(made, 100, 0.1)[1], np.full(100, 0.1)))
    assert refined.points == 100
    assert refined.sightings == 600
    assert refined.mean_px < 0.15
    before = farthest_off(solved.adjusted.cameras, made)
    assert farthest_off(refined.solved.adjusted.cameras, made) < before / 3


def test_known_centres_hold_the_cameras_as_well_as_they_are_met(made: MadeRoom, solved: Solved) -> None:
    """Centres that are known exactly help the rest of the calibration; bad ones do no harm."""
    places = TargetSightings(shown(made, 20, 0.5)[1], np.full(20, 0.5))
    free = with_targets(solved, places).solved
    random, away = np.random.default_rng(4), {}
    for error in (0.0, 0.03):
        known = {camera.name: camera.center + error * random.normal(size=3) for camera in made.cameras}
        alignment = onto_centers(free.adjusted.cameras, known, scaled=True)
        held = with_targets(free, places, alignment).solved.adjusted.cameras
        assert onto_centers(held, known, scaled=True).transform.scale == pytest.approx(1, abs=1e-4)
        away[error] = farthest_off(held, made)
    before = farthest_off(free.adjusted.cameras, made)
    assert away[0.0] < before
    assert away[0.03] < 1.2 * before


@pytest.mark.thorough
def test_targets_improve_unknown_lenses(made: MadeRoom) -> None:
    solved = solve(made.sightings, None)
    refined = with_targets(solved, TargetSightings(shown(made, 100, 0.1)[1], np.full(100, 0.1))).solved
    away = [
        max(
            abs(found.matrix[0, 0] / true.matrix[0, 0] - 1)
            for found, true in zip(one.adjusted.cameras, made.cameras, strict=True)
        )
        for one in (solved, refined)
    ]
    assert away[1] < away[0] / 3


def test_a_third_of_the_sightings_elsewhere_does_no_harm(made: MadeRoom, solved: Solved) -> None:
    pixel = shown(made, 100, 0.1)[1]
    pixel[::3, 2] += 60
    pixel[1::3, 4] = np.nan
    refined = with_targets(solved, TargetSightings(pixel, np.full(100, 0.1)))
    assert refined.sightings == np.isfinite(pixel[..., 0]).sum() - 34
    assert (
        farthest_off(refined.solved.adjusted.cameras, made) < farthest_off(solved.adjusted.cameras, made) / 3
    )


def test_clips_that_are_not_synchronised_are_told(made: MadeRoom, solved: Solved) -> None:
    pixel = shown(made, 100, 0.1)[1]
    for number in range(6):
        pixel[:, number] = np.roll(pixel[:, number], 7 * number, axis=0)
    with pytest.raises(FollowspotError, match=r"of 600 sightings .* clips must be synchronised"):
        with_targets(solved, TargetSightings(pixel, np.full(100, 0.1)))


@pytest.mark.parametrize("cameras", [3, 8])
def test_the_noise_is_that_of_the_sightings_not_of_what_the_points_leave(cameras: int) -> None:
    made = made_room(cameras, 200, noise=0.5)
    adjusted = solve(made.sightings, list(made.cameras), "known").adjusted
    assert noise(adjusted) == pytest.approx(0.5, rel=0.1)


@pytest.fixture
def clips(made: MadeRoom, tmp_path: Path) -> Path:
    """Discs where the cameras see two targets; cam5 has no clip of the second one."""
    pixel = shown(made, 2 * FRAMES, 0.0)[1].reshape(2, FRAMES, 6, 2)
    for number, target in enumerate(("red", "blue")):
        for camera in made.cameras[: 6 - number]:
            folder = tmp_path / "clips" / target / camera.name
            folder.mkdir(parents=True)
            for frame, (u, v) in enumerate(pixel[number, :, int(camera.name[3:])]):
                picture = np.zeros((camera.size[1], camera.size[0], 3), "u1")
                middle, radius = (round(u * 16), round(v * 16)), 16 * WIDTH // 2
                cv2.circle(picture, middle, radius, (40, 40, 250), -1, cv2.LINE_AA, 4)
                cv2.imwrite(str(folder / f"{frame:03d}.png"), picture)
    return tmp_path / "clips"


def test_targets_are_found_in_their_clips_below_a_pixel(made: MadeRoom, clips: Path) -> None:
    places = find_target_sightings(clips, made.cameras)
    truth = shown(made, 2 * FRAMES, 0.0)[1].reshape(2, FRAMES, 6, 2)[::-1].reshape(-1, 6, 2)
    away = np.linalg.norm(places.pixel - truth, axis=2)
    assert np.isnan(away[:FRAMES, 5]).all()
    assert np.nanmean(away) < 0.1
    assert np.nanmax(away) < 0.25
    assert places.sigma == pytest.approx(0.03 * WIDTH, rel=0.15)


def test_targets_of_a_single_camera_are_no_points(made: MadeRoom, clips: Path) -> None:
    with pytest.raises(FollowspotError, match="no target is seen by two cameras"):
        find_target_sightings(clips, made.cameras[:1])


@pytest.mark.thorough
def test_the_command_takes_targets_along(
    made: MadeRoom, solved: Solved, clips: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = made.sightings
    rows = [
        f"{frame},{camera},{u},{v}"
        for frame, views in zip(seen.frame, seen.pixel.tolist(), strict=True)
        for camera, (u, v) in zip(seen.cameras, views, strict=True)
        if np.isfinite(u)
    ]
    (tmp_path / "wand.csv").write_text("\n".join(["frame,camera,u,v", *rows]))
    stale = {c.name: replace(c, rotation=np.eye(3), translation=-c.center) for c in made.cameras}
    room, wand = str(tmp_path / "room.yaml"), str(tmp_path / "wand.csv")
    save(Room("studio", stale), room)
    arguments = ["calibrate", "wand", "--points", wand, "--room", room, "--targets", str(clips), "--json"]
    assert main(arguments) == 0
    cameras = list(load(room).cameras.values())
    assert farthest_off(cameras, made) < farthest_off(solved.adjusted.cameras, made) / 2
    assert "<h1>Wand of studio</h1>" in (tmp_path / "room.wand.html").read_text()
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["targets"]["points"] == 2 * FRAMES
    alone = ["calibrate", "wand", "--points", wand, "--size", "640x480", "-o", room]
    assert main([*alone, "--targets", str(clips)]) == 2
    assert "--targets needs a room" in capsys.readouterr().err
