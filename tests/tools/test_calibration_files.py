"""Calibrations of real rooms, as other programs wrote them."""

import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot_calibrate.triangulation import triangulate
from followspot_room.calibration import NO_POSES, read_calibration

POSE2SIM = dataset("room-pose2sim-single-4cam")
pytestmark = needs_data("room-pose2sim-single-4cam", "calib-charuco-4cam-caliscope", "opencv-samples")


def test_both_calibrations_of_one_room_agree_on_the_lenses() -> None:
    """Two laboratories, two methods: focal lengths within 1 %, distortion of the same strength.

    The distortion settles that Qualisys' coefficients are OpenCV's and not 64 times those.
    """
    qualisys = read_calibration(POSE2SIM / "Calib.qca.txt").cameras
    scene = read_calibration(POSE2SIM / "Calib_scene.toml")
    assert scene.notes == (NO_POSES,)
    assert [c.name for c in qualisys] == [c.name for c in scene.cameras]
    for a, b in zip(qualisys, scene.cameras, strict=True):
        assert a.size == b.size == (1088, 1920)
        assert a.matrix[0, 0] == pytest.approx(b.matrix[0, 0], rel=0.01)
        assert a.distortion[0] == pytest.approx(b.distortion[0], abs=0.02)


def test_cameras_of_qualisys_stand_around_the_room_and_look_into_it() -> None:
    for camera in read_calibration(POSE2SIM / "Calib.qca.txt").cameras:
        assert 1.6 < camera.center[2] < 2.2  # m above the floor
        toward = -camera.center / np.linalg.norm(camera.center)
        assert camera.rotation[2] @ toward > 0.9  # the middle of the floor lies ahead
        assert camera.rotation[1, 2] < -0.8  # down in the picture is down in the room


def test_qualisys_axes_agree_with_the_videos() -> None:
    """Marked by hand in the first pictures, to about 10 px: the swimming cap and two bollards.

    The four cameras agree on where they are, and the bollards stand on the floor on both sides of the x axis.
    """
    cameras = read_calibration(POSE2SIM / "Calib.qca.txt").cameras
    marked = np.array(
        [
            [[486, 329], [538, 393], [608, 418], [253, 479]],
            [[658, 1511], [272, 1311], [261, 966], [838, 852]],
            [[941, 1414], [638, 1333], [64, 1054], [616, 918]],
        ],
        float,
    )
    found = triangulate(cameras, marked)
    assert found.used.sum(axis=1).min() >= 3
    assert np.linalg.norm(found.residual, axis=2).max() < 30
    cap, left, right = found.points
    assert 1.6 < cap[2] < 1.9
    np.testing.assert_allclose(left * [1, -1, 1], right, atol=0.03)


def test_old_and_new_files_of_caliscope_say_the_same() -> None:
    folder = dataset("calib-charuco-4cam-caliscope")
    new = read_calibration(folder / "camera_array.toml").cameras
    old = read_calibration(folder / "config.toml").cameras
    assert [c.name for c in new] == [c.name for c in old] == ["cam_0", "cam_1", "cam_2", "cam_3"]
    for a, b in zip(new, old, strict=True):
        np.testing.assert_array_equal(a.projection, b.projection)
        np.testing.assert_array_equal(a.distortion, b.distortion)


def test_sample_of_opencv_is_read() -> None:
    (camera,) = read_calibration(dataset("opencv-samples") / "left_intrinsics.yml").cameras
    assert (camera.name, camera.size) == ("left_intrinsics", (640, 480))
    assert camera.matrix[0, 0] == pytest.approx(535.9157, abs=1e-4)
    assert camera.distortion[4] == pytest.approx(0.23839, abs=1e-5)
