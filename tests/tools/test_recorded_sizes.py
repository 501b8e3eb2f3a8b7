"""Recordings that are not as large as the calibration says."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot import Camera, InputError
from followspot.geometry import project
from followspot_room.recorded_size import as_recorded, picture_size

POINT = np.array([[0.3, -0.2, 4.0]])


def camera(width: int, height: int) -> Camera:
    matrix = np.array([[900.0, 0, 470.5], [0, 900.0, 500.0], [0, 0, 1]])
    return Camera("cam", "color", (width, height), matrix, np.zeros(5), np.eye(3), np.zeros(3))


def test_pictures_of_the_calibrated_size_change_nothing() -> None:
    known = camera(1088, 1920)
    assert as_recorded(known, (1088, 1920)) == (known, "")
    assert as_recorded(known, None) == (known, "")


def test_what_a_codec_cut_off_leaves_the_matrix_as_it_is() -> None:
    found, note = as_recorded(camera(1088, 1920), (1080, 1920))
    assert found.size == (1080, 1920)
    assert np.array_equal(found.matrix, camera(1088, 1920).matrix)
    assert "1088x1920" in note
    assert "cut off" in note


def test_a_smaller_copy_shows_the_same_point_at_the_same_share_of_the_picture() -> None:
    found, note = as_recorded(camera(960, 1280), (480, 640))
    small, large = project(found, POINT)[0] + 0.5, project(camera(960, 1280), POINT)[0] + 0.5
    assert np.allclose(small / (480, 640), large / (960, 1280))
    assert "scaled" in note


def test_a_picture_of_another_shape_is_refused_with_both_sizes() -> None:
    with pytest.raises(InputError, match="calibrated at 960x1280 px and recorded at 640x480 px"):
        as_recorded(camera(960, 1280), (640, 480))


def test_the_size_of_a_recording_is_that_of_its_pictures(tmp_path: Path) -> None:
    writer = cv2.VideoWriter(str(tmp_path / "a.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30, (64, 48))
    writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    (tmp_path / "b").mkdir()
    assert picture_size(tmp_path / "b") is None
    cv2.imwrite(str(tmp_path / "b/0.png"), np.zeros((30, 40, 3), np.uint8))
    assert picture_size(tmp_path / "a.avi") == (64, 48)
    assert picture_size(tmp_path / "b") == (40, 30)


def test_a_video_that_is_none_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "cam.mkv").write_text("no video")
    with pytest.raises(InputError, match=r"cam\.mkv cannot be read as a video"):
        picture_size(tmp_path / "cam.mkv")
