"""Corners of markers in pictures."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from tests.plugins.vision.marker_room import ROOM, SIZE

from followspot import Context
from followspot.geometry import project, undistort
from followspot.message_checks.sealing import seal
from followspot.tracking import Frame
from followspot_sim.marker_camera import MarkerCamera, marker_pose
from followspot_vision.aruco import Aruco
from followspot_vision.edge_corners import edge_corners
from followspot_vision.square_pose import square


def aruco(name: str = "left", **params: object) -> Aruco:
    stage = Aruco(Context.serving(ROOM.cameras[name], ROOM), **params)
    stage.setup()
    return stage


def shot(name: str, time: float = 0.0) -> Frame:
    camera = MarkerCamera(Context.serving(ROOM.cameras[name], ROOM))
    camera.setup()
    gray = camera.picture(time).clip(0, 255).round().astype(np.uint8)
    return Frame(name, np.repeat(gray[..., None], 3, axis=2))


@pytest.mark.parametrize("name", ROOM.cameras)
def test_corners_are_where_the_marker_is_clockwise_from_its_upper_left(name: str) -> None:
    found = seal(aruco(name).process(shot(name)))
    assert found.names == ("0", "1", "2")[: len(found.names)]
    assert len(found.names) >= 2
    for row, marker in enumerate(found.id.tolist()):
        rotation, xyz = marker_pose(marker, 3, 0.0)
        true = square(SIZE) @ rotation.T + xyz
        off = np.abs(found.pixel[row] - project(ROOM.cameras[name], true))
        assert np.median(off) < 0.1
        assert off.max() < 0.3
        assert np.allclose(found.xy[row], undistort(ROOM.cameras[name], found.pixel[row]))


def test_corners_from_the_sides_are_not_pulled_inwards_as_those_of_opencv_are() -> None:
    errors = {}
    for refinement in ("edges", "subpixel", "none"):
        found = aruco(refinement=refinement).process(shot("left", 1.0))
        off = []
        for row, marker in enumerate(found.id.tolist()):
            rotation, xyz = marker_pose(marker, 3, 1.0)
            true = project(ROOM.cameras["left"], square(SIZE) @ rotation.T + xyz)
            out = (true - true.mean(axis=0)) / np.linalg.norm(true - true.mean(axis=0), axis=1, keepdims=True)
            off.append(((found.pixel[row] - true) * out).sum(axis=1))
        errors[refinement] = abs(np.mean(off))
    assert errors["edges"] < 0.03
    assert errors["edges"] < errors["subpixel"] / 5 < errors["none"] / 5


def test_a_side_that_cannot_be_measured_leaves_the_corners_as_they_were() -> None:
    flat, corners = np.full((480, 640), 90, np.uint8), np.array([[9, 9], [40, 9], [40, 40], [9, 40.0]])
    assert edge_corners(ROOM.cameras["left"], flat, corners).tolist() == corners.tolist()
    half = flat.copy()
    half[:, :25] = 250
    assert edge_corners(ROOM.cameras["left"], half, corners).tolist() == corners.tolist()


def test_only_markers_that_are_asked_for_are_found_and_have_their_names() -> None:
    found = aruco("top", ids=[2, 0, 7], names={2: "hat"}).process(shot("top"))
    assert found.id.tolist() == [0, 2]
    assert found.names == ("0", "hat")


@pytest.mark.parametrize(
    ("dictionary", "last"), [("DICT_4X4_50", 49), ("DICT_4X4_100", 99), ("DICT_APRILTAG_16h5", 29)]
)
def test_markers_that_the_dictionary_has_not_are_mistakes(dictionary: str, last: int) -> None:
    def found(**params: object) -> list[tuple[str, str]]:
        checked = Aruco.check_files(Aruco.Params(dictionary=dictionary, **params), ROOM, None)
        return [(mistake.text, mistake.remedy) for mistake in checked]

    remedy = f"its markers are 0 to {last}"
    assert found(ids=[0, last], names={last: "hat"}) == []
    assert found(ids=[0, last + 1]) == [(f"ids: {dictionary} has no marker {last + 1}", remedy)]
    assert found(names={-1: "hat"}) == [(f"names: {dictionary} has no marker -1", remedy)]


def test_of_two_markers_with_one_name_the_larger_is_taken() -> None:
    board = np.full((480, 640, 3), 255, np.uint8)
    marker = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 7, 200)
    board[100:300, 40:240] = marker[..., None]
    board[100:200, 400:500] = marker[::2, ::2, None]
    for pixels in (board, board[:, ::-1][::-1].copy()):
        found = aruco().process(Frame("left", pixels))
        assert found.names == ("7",)
        assert np.ptp(found.pixel[0], axis=0).min() > 150


@pytest.mark.parametrize("dictionary", ["DICT_APRILTAG_36h11", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL"])
def test_other_dictionaries_are_read_too(dictionary: str) -> None:
    board = np.full((480, 640, 1), 255, np.uint8)
    printed = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    board[100:300, 100:300, 0] = cv2.aruco.generateImageMarker(printed, 23, 200)
    assert aruco(dictionary=dictionary).process(Frame("left", board)).id.tolist() == [23]
    assert aruco().process(Frame("left", board)).id.tolist() == []
