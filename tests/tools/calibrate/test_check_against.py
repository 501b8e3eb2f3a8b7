"""`calibrate check --against`: two calibrations of the same cameras."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.rooms import made_room

from followspot import Camera
from followspot.cli.main import main
from followspot.errors import InputError
from followspot_calibrate.check.against import common_points, compare
from followspot_calibrate.similarity import Similarity

POSE2SIM = dataset("room-pose2sim-single-4cam")
needs_recordings = needs_data("room-pose2sim-single-4cam")
CAMERAS = made_room(4, 1).cameras


def elsewhere(camera: Camera, meters: float, degrees: float) -> Camera:
    rotation = cv2.Rodrigues(np.array([0, np.radians(degrees), 0]))[0] @ camera.rotation
    center = camera.center + np.array([0, meters, 0])
    return replace(camera, rotation=rotation, translation=-rotation @ center)


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(*[st.floats(-3, 3)] * 3),
    st.tuples(*[st.floats(-9, 9)] * 3),
    st.floats(0.01, 100),
    st.integers(2, 4),
)
def test_another_frame_and_scale_is_no_difference(
    turn: tuple[float, ...], shift: tuple[float, ...], scale: float, count: int
) -> None:
    moved = Similarity(cv2.Rodrigues(np.array(turn))[0], np.array(shift), scale)
    found = compare(CAMERAS[:count], [moved.camera(camera) for camera in CAMERAS[:count]])
    assert found.scale * scale == pytest.approx(1)
    for one in found.cameras:
        assert one.center_mm < 1e-3
        assert one.angle_deg < 1e-4
        assert one.mean_px < 1e-3
        assert one.focal_percent == one.principal_px == 0


def test_one_camera_that_moved_does_not_drag_the_others() -> None:
    other = [elsewhere(c, 0.05, 2.0) if n == 1 else c for n, c in enumerate(CAMERAS)]
    found = compare(CAMERAS, other).cameras
    assert found[1].center_mm == pytest.approx(50, abs=0.5)
    assert found[1].angle_deg == pytest.approx(2, abs=0.01)
    assert found[1].mean_px > 10
    assert max(one.center_mm for n, one in enumerate(found) if n != 1) < 0.5


def test_lenses_are_compared_by_focal_length_principal_point_and_picture() -> None:
    matrix = CAMERAS[0].matrix * [[1.02, 1, 1], [1, 1.02, 1], [1, 1, 1]]
    matrix[:2, 2] += [3, 4]
    found = compare(CAMERAS, [replace(CAMERAS[0], matrix=matrix), *CAMERAS[1:]]).cameras[0]
    assert found.focal_percent == pytest.approx(2)
    assert found.principal_px == pytest.approx(5)
    assert 4 < found.lens_px < 12


def test_calibrations_without_poses_are_compared_by_their_lenses() -> None:
    nowhere = [replace(c, rotation=np.eye(3), translation=np.zeros(3)) for c in CAMERAS]
    for found in (compare(CAMERAS, nowhere), compare(nowhere, CAMERAS)):
        assert "no camera poses" in found.notes[0]
        assert np.isnan(found.scale)
        assert all(np.isnan(one.center_mm) and one.judged_px < 1e-6 for one in found.cameras)


def test_cameras_correspond_by_name_else_by_order() -> None:
    renamed = [replace(camera, name=f"left{n}") for n, camera in enumerate(CAMERAS)]
    found = compare(CAMERAS, renamed)
    assert "correspond by order: cam0 = left0" in found.notes[0]
    assert [one.other for one in found.cameras] == ["left0", "left1", "left2", "left3"]
    assert "only in one of the two: cam3" in compare(CAMERAS, CAMERAS[:3]).notes[0]
    with pytest.raises(InputError, match="share 0 cameras"):
        compare(CAMERAS, renamed[:3])


def test_compared_points_are_where_the_cameras_look() -> None:
    points = common_points(CAMERAS)
    assert len(points) > 500
    assert np.abs(points.mean(axis=0) - [0, 0, 0.9]).max() < 0.5


@needs_recordings
def test_two_calibrations_of_one_lab_are_imported_and_their_difference_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room, other = str(tmp_path / "room.yaml"), str(POSE2SIM / "Calib_scene.toml")
    assert main(["room", "import", str(POSE2SIM / "Calib.qca.txt"), "-o", room]) == 0
    capsys.readouterr()
    assert main(["calibrate", "check", "--room", room, "--against", other, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found["against"]["cameras"]) == ["cam01", "cam02", "cam03", "cam04"]
    for one in found["against"]["cameras"].values():
        assert abs(one["focal_percent"]) < 1
        assert 29 < one["lens_px"] < 52
        assert one["center_mm"] is None  # the second file holds lenses only
    assert any("no camera poses" in text for text in found["warnings"])
    assert main(["calibrate", "check", "--room", room, "--against", other, "--limit", "5"]) == 1
    assert "look at cam01, cam02, cam03, cam04" in capsys.readouterr().out
