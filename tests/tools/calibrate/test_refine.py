"""`calibrate refine`: cameras that are slightly off are corrected by what an ordinary tracking run saw."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.carried_targets import FLOOR, RADIUS, TRUE, carried, off
from tests.tools.calibrate.rooms import camera_of

from followspot import Camera, Room, Target
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.messages import Array
from followspot.room_file import load, save
from followspot_calibrate.adjust import Prior
from followspot_calibrate.adjust.projection import moved, rotation_of
from followspot_calibrate.refine.arguments import GRAPH
from followspot_calibrate.refine.planes import as_seen
from followspot_calibrate.refine.selection import concatenated, select_sightings, widths
from followspot_calibrate.refine.solving import OPEN, prior_of, refine
from followspot_calibrate.similarity import similarity
from followspot_calibrate.target_sightings import TargetSightings
from followspot_calibrate.triangulation import triangulate
from followspot_calibrate.wand.rounds import SCALE, chosen

ROOT = Path(__file__).parents[3]
GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")


def error_mm(cameras: Sequence[Camera], true: Sequence[Camera], points: Array) -> float:
    """RMSE of exact images of points, triangulated with other cameras, mm."""
    exact = np.stack([project(camera, points) for camera in true], axis=1)
    away = triangulate(cameras, exact).points - points
    return float(1000 * np.sqrt(np.square(away).sum(axis=1).mean()))


def bent_mm(cameras: Sequence[Camera], true: Sequence[Camera], points: Array) -> float:
    """The same after the best rigid motion, for where cameras stand together no tracker can see."""
    exact = np.stack([project(camera, points) for camera in true], axis=1)
    found = triangulate(cameras, exact).points
    away = similarity(found, points, scaled=False).points(found) - points
    return float(1000 * np.sqrt(np.square(away).sum(axis=1).mean()))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_cameras_that_are_slightly_off_are_corrected(seed):
    points, pixel = carried()
    given = off(TRUE, seed)
    found = refine(given, select_sightings(given, pixel, np.full(len(points), RADIUS), FLOOR), FLOOR)
    assert bent_mm(found.after.cameras, TRUE, points) < 0.7 * bent_mm(given, TRUE, points)
    assert found.after.sigma < 0.6 * found.before.sigma


def test_clips_of_targets_tell_what_a_recording_leaves_open():
    """Targets were carried in a corner of the room only; in their clips they are everywhere."""
    points, pixel = carried(1200)
    corner = (points < 0.8).all(axis=1)
    given, radius = off(TRUE), np.full(len(points), RADIUS)
    alone = select_sightings(given, pixel[corner][:300], radius[corner][:300], FLOOR)
    clips = TargetSightings(pixel[~corner][:100], np.full(100, 0.2))
    bent = [
        bent_mm(refine(given, some, FLOOR).after.cameras, TRUE, points)
        for some in (alone, concatenated(alone, clips))
    ]
    assert bent[1] < 0.8 * bent[0]


def test_fisheye_cameras_are_corrected_as_well_as_their_lenses_allow():
    """Their lenses stay as they are, places and directions do not."""
    lens = {"model": "fisheye", "distortion": np.array([0.02, -0.01, 0.0, 0.0])}
    true = [replace(camera, **lens) if i in (2, 4) else camera for i, camera in enumerate(TRUE)]
    points, _ = carried(150)
    exact = np.stack([project(camera, points) for camera in true], axis=1)
    places = TargetSightings(
        exact + 0.2 * np.random.default_rng(1).normal(size=exact.shape), np.full(150, 0.2)
    )
    given = [replace(camera, **lens) if i in (2, 4) else camera for i, camera in enumerate(off(TRUE))]
    found = refine(given, places, FLOOR)
    assert found.after.sigma < 0.6 * found.before.sigma
    for old, new in zip(given, found.after.cameras, strict=True):
        assert new.model == old.model
        assert np.array_equal(new.distortion, old.distortion) == (old.model == "fisheye")
        assert not np.array_equal(new.rotation, old.rotation)


def test_true_cameras_stay_where_they_are():
    points, pixel = carried()
    found = refine(TRUE, select_sightings(TRUE, pixel, np.full(len(points), RADIUS), FLOOR), FLOOR)
    assert error_mm(found.after.cameras, TRUE, points) < 1.0


def test_the_frame_of_reference_is_that_of_the_given_centres():
    points, pixel = carried()
    given = off(TRUE)
    found = refine(given, select_sightings(given, pixel, np.full(len(points), RADIUS), FLOOR), FLOOR)
    shift = np.mean(
        [new.center - old.center for new, old in zip(found.after.cameras, given, strict=True)], axis=0
    )
    assert shift == pytest.approx(0, abs=1e-9)


def test_gross_errors_do_not_move_the_cameras():
    points, pixel = carried()
    wrong = pixel.copy()
    wrong[::7, 2] += [3.0, -4.0]
    radius, given = np.full(len(points), RADIUS), off(TRUE)
    clean, spoilt = (
        refine(given, select_sightings(given, seen, radius, FLOOR), FLOOR).after.cameras
        for seen in (pixel, wrong)
    )
    assert error_mm(spoilt, TRUE, points) < error_mm(clean, TRUE, points) + 0.5


def test_the_light_around_a_target_on_the_floor_does_not_count():
    """A colour camera sees a ball that lies on the floor together with the light around it."""
    points, pixel = carried()
    points[::2, 2] = RADIUS
    pixel[::2] = np.stack([project(camera, points[::2]) for camera in TRUE], axis=1)
    pixel[::2, :, 1] += 1.0
    found = refine(TRUE, select_sightings(TRUE, pixel, np.full(len(points), RADIUS), FLOOR), FLOOR)
    assert error_mm(found.after.cameras, TRUE, points) < 1.0


def test_planes_stay_where_the_cameras_see_them():
    points, _ = carried()
    given = off(TRUE)
    seen = as_seen(FLOOR, TRUE, given, points)["floor"]
    feet = points * [1, 1, 0]
    marks = triangulate(given, np.stack([project(camera, feet) for camera in TRUE], axis=1)).points
    assert np.abs(marks @ seen[:3] + seen[3]).max() < 0.002
    assert seen[2] > 0.99
    assert as_seen(FLOOR, TRUE, given, points[:2])["floor"] is FLOOR["floor"]


def test_a_camera_that_saw_too_little_is_named():
    points, pixel = carried(100)
    pixel[5:, 3] = np.nan
    with pytest.raises(FollowspotError, match="cam3: 5 sightings"):
        refine(TRUE, select_sightings(TRUE, pixel, np.full(len(points), RADIUS), FLOOR), FLOOR)


def test_a_target_is_as_wide_as_the_cameras_see_it_on_average():
    lens = {"distortion": np.zeros(5), "rotation": np.eye(3)}
    near, far = (
        replace(camera, **lens, translation=np.array([0.0, 0.0, z]))
        for camera, z in zip(TRUE, (2, 5), strict=False)
    )
    ends = np.array([[RADIUS, 0.0, 0.0], [-RADIUS, 0.0, 0.0]])
    seen = [np.linalg.norm(np.diff(project(camera, ends), axis=0)) for camera in (near, far)]
    assert widths([near, far], np.zeros((1, 3)), np.array([RADIUS])) == pytest.approx([np.mean(seen)])


def test_each_cause_may_move_pixels_by_as_much():
    """One sigma of a direction or centre moves the middle of the picture, one of a lens its edge, alike."""
    camera = replace(TRUE[0], distortion=np.zeros(5))
    adjusted = chosen([camera, *TRUE[1:]], carried(50)[1])
    sigma = prior_of(adjusted).sigma[0]
    edge = max(camera.size) / 2 / camera.matrix[0, 0]
    depth = np.nanmedian(np.linalg.norm(adjusted.points - camera.center, axis=1))
    places = camera.center + depth * np.array([[0, 0, 1], [edge, 0, 1], [0, edge, 1]]) @ camera.rotation
    turned = rotation_of(np.array([sigma[0], 0.0, 0.0])) @ camera.rotation
    others = [
        replace(camera, rotation=turned, translation=-turned @ camera.center),
        replace(camera, translation=camera.translation + sigma[3] * np.eye(3)[0]),
        *(moved(camera, step, OPEN) for step in np.diag(sigma)[6:]),
    ]
    shift = np.array([project(other, places) - project(camera, places) for other in others])
    far = np.linalg.norm(shift, axis=2)
    allowed = SCALE * adjusted.sigma / np.sqrt(3)
    assert [*far[:2, 0], *far[2:].max(axis=1)] == pytest.approx([allowed] * 8, rel=0.03)


def test_the_derivatives_of_a_prior_are_those_of_its_errors():
    camera = off(TRUE)[0]
    prior = Prior([TRUE[0]], np.full((1, OPEN.parameters), 0.5))
    step = 1e-6
    steps = step * np.eye(OPEN.parameters)
    rows = [
        prior.errors(0, moved(camera, one, OPEN), OPEN) - prior.errors(0, moved(camera, -one, OPEN), OPEN)
        for one in steps
    ]
    told = prior.by_parameters(0, camera, OPEN)
    assert told == pytest.approx(np.array(rows).T / (2 * step), abs=5e-3)


@pytest.mark.thorough
@needs_recordings
def test_a_noisy_calibration_is_corrected_from_one_recording(tmp_path, capsys):
    """glowballs-dev, six balls in three seconds: 6 mm become less than 2.5 mm; planes follow the cameras."""
    room, noisy = tmp_path / "room.yaml", GLOWBALLS / "calibration_noisy.json"
    assert main(["room", "import", str(noisy), "--videos", str(GLOWBALLS / "dev3"), "-o", str(room)]) == 0
    learning = ["calibrate", "targets", "--room", str(room), "--clips", str(GLOWBALLS / "templates")]
    assert main([*learning, "--keep-cameras"]) == 0
    given = json.loads((GLOWBALLS / "calibration.json").read_text())["cameras"]
    true = [camera_of(one["name"], (320, 240), one) for one in given]
    points = np.random.default_rng(0).uniform([0.5, -1.0, 0.1], [3.5, 1.5, 1.6], (200, 3))
    before = load(room)
    assert error_mm(list(before.cameras.values()), true, points) > 5
    graph, out, clips = tmp_path / "graph.yaml", str(tmp_path / "out"), str(GLOWBALLS / "templates")
    blobs = {"uses": "sinks.csv", "in": {"blobs": ["color", "infrared"]}, "with": {"path": "blobs.csv"}}
    graph.write_text(json.dumps({"extends": str(ROOT / GRAPH), "stages": {"blobs": blobs}}))
    capsys.readouterr()
    tracking = ["run", str(graph), "--room", str(room), "--out", out, "--frames", "100", "--json", "--quiet"]
    assert main(tracking) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert any("cameras contradict each other" in text and "calibrate refine" in text for text in warnings)
    command, text = ["calibrate", "refine", "--room", str(room), "--json"], room.read_text()
    assert main([*command, "--graph", str(ROOT / GRAPH), "--frames", "70", "--dry-run"]) == 0
    capsys.readouterr()
    assert main([*command, "--run", out, "--dry-run", "--clips", clips]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert room.read_text() == text
    assert main([*command, "--run", out]) == 0
    told = json.loads(capsys.readouterr().out)
    assert shown["places"] == told["places"] + 120
    after = load(room)
    assert error_mm(list(after.cameras.values()), true, points) < 2.5
    assert all(one["after_px"] < 0.5 * one["before_px"] for one in told["cameras"].values())
    assert all(0 < np.abs(after.planes[name] - plane).max() < 0.01 for name, plane in before.planes.items())
    assert after.targets.keys() == before.targets.keys()
    assert "Refinement of room" in room.with_suffix(".refine.html").read_text()


@pytest.mark.parametrize(("count", "told"), [(2, "three or more are needed"), (6, "has no targets")])
def test_a_room_that_cannot_be_refined_is_refused(count, told, tmp_path, capsys):
    path = tmp_path / "room.yaml"
    save(Room("studio", {camera.name: replace(camera) for camera in TRUE[:count]}), path)
    assert main(["calibrate", "refine", "--room", str(path)]) == 2
    assert told in capsys.readouterr().err


def test_a_run_without_blobs_is_refused_with_what_the_command_can_do(tmp_path, capsys):
    path = tmp_path / "room.yaml"
    save(Room("studio", {camera.name: camera for camera in TRUE}, targets={"red": Target("red", 0.05)}), path)
    assert main(["calibrate", "refine", "--room", str(path), "--run", str(tmp_path)]) == 2
    refused = capsys.readouterr().err
    assert "has no blobs.csv" in refused
    assert "or leave --run out" in refused
    assert "--track" not in refused
