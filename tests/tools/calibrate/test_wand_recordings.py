"""`calibrate wand` on recordings: real rooms, and a rendered one with its truth."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.rooms import camera_of

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.points_file import read_points
from followspot_calibrate.similarity import similarity, spread
from followspot_calibrate.wand.solving import solve


@needs_data("selfcal-mcsc-2010")
def test_the_old_toolbox_is_beaten_on_its_own_recording():
    """selfcal-mcsc-2010: its own figure is a mean of 0.62 px; here over all points, also those left out."""
    solved = solve(read_points(dataset("selfcal-mcsc-2010")), None)
    adjusted, seen = solved.adjusted, solved.sightings.seen.sum()
    every = np.hypot(adjusted.residual[..., 0], adjusted.residual[..., 1])
    assert np.isfinite(every).sum() > 0.99 * seen
    assert np.nanmean(every) < 0.62
    assert np.nanmean(adjusted.distance) < 0.4
    assert adjusted.used.sum() > 0.9 * seen


@pytest.mark.thorough
@needs_data("selfcal-ball-9cam")
def test_nine_cameras_and_a_ball_agree_with_their_authors():
    """selfcal-ball-9cam, every 20th frame: median under 3.1 px, shape within 1 % of the authors'."""
    folder = dataset("selfcal-ball-9cam")
    rough = json.loads((folder / "intrinsics_initial.json").read_text())
    poses = json.loads((folder / "reference_calibration_unscaled.json").read_text())["reference_poses"]
    cameras = [nine(number, rough[str(number)]) for number in range(9)]
    authors = np.array([nine(number, poses[str(number)]).center for number in range(9)])
    sightings = read_points(folder / "single_ball.npz", cameras, confidence=0.5)
    solved = solve(sightings.rows(slice(None, None, 20)), cameras, "auto")
    assert solved.intrinsics == "refined"
    assert np.nanmedian(solved.adjusted.distance) < 3.1
    assert solved.adjusted.used.sum() > 0.9 * solved.sightings.seen.sum()
    centers = np.array([camera.center for camera in solved.adjusted.cameras])
    apart = similarity(centers, authors).points(centers) - authors
    assert np.sqrt(np.square(apart).sum(axis=1).mean()) < 0.01 * spread(authors)


@needs_data("glowballs-dev")
def test_a_wand_in_the_rendered_room_places_the_cameras():
    """glowballs-dev: within 5 mm and 0.2 degrees of the truth, mean under 0.4 px."""
    truth = glowballs()
    sightings = read_points(dataset("glowballs-dev") / "wand/points.csv", truth)
    solved = solve(sightings, truth, "auto")
    assert solved.intrinsics == "known"
    assert np.nanmean(solved.adjusted.distance) < 0.4
    millimetres, degrees = differences(solved.adjusted.cameras, truth)
    assert millimetres.max() < 5
    assert degrees.max() < 0.2


@needs_data("glowballs-dev")
def test_a_wand_in_the_rendered_room_finds_the_intrinsics_too():
    """glowballs-dev with nothing known: focal lengths within 2 %, centres within 4 cm (depth ratio 1.6)."""
    truth = glowballs()
    solved = solve(read_points(dataset("glowballs-dev") / "wand/points.csv", truth), truth, "free")
    assert np.nanmean(solved.adjusted.distance) < 0.4
    assert differences(solved.adjusted.cameras, truth)[0].max() < 40
    for found, true in zip(solved.adjusted.cameras, truth, strict=True):
        assert found.matrix[0, 0] == pytest.approx(true.matrix[0, 0], rel=0.02)


def differences(cameras, truth) -> tuple[Array, Array]:
    """Of centres, mm, and of rotations, degrees, once the centres are aligned."""
    target = np.array([camera.center for camera in truth])
    transform = similarity(np.array([camera.center for camera in cameras]), target)
    found = [transform.camera(camera) for camera in cameras]
    apart = np.linalg.norm([c.center for c in found] - target, axis=1)
    traces = np.array([np.trace(c.rotation @ t.rotation.T) for c, t in zip(found, truth, strict=True)])
    return 1000 * apart, np.degrees(np.arccos(np.clip((traces - 1) / 2, -1, 1)))


def glowballs() -> list[Camera]:
    calibration = json.loads((dataset("glowballs-dev") / "calibration.json").read_text())
    return [camera_of(one["name"], (320, 240), one) for one in calibration["cameras"]]


def nine(number: int, given) -> Camera:
    return camera_of(f"cam{number}", (1280, 800), given)
