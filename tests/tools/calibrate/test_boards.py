"""Boards: what users call them, and where their corners are found."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.drawn_boards import Photographer, Place, lens

from followspot.errors import InputError
from followspot.geometry import project
from followspot_calibrate.boards.board import Board, parse_board
from followspot_calibrate.boards.detection import Detector

CHARUCO = "charuco:5x4:0.05:DICT_4X4_50"
MARKER = "aruco:0.2:DICT_4X4_50:7"
CHESSBOARD = "chessboard:7x4:0.05"
PLACE = Place((0.3, -0.4, 0.2), (0.02, -0.03, 0.6))


@pytest.mark.parametrize(
    ("text", "board"),
    [
        ("chessboard:9x6:0.025", Board("chessboard", 9, 6, 0.025)),
        (CHARUCO, Board("charuco", 5, 4, 0.05, 0.75 * 0.05, "DICT_4X4_50")),
        (MARKER, Board("aruco", 2, 2, 0.2, 0.2, "DICT_4X4_50", number=7)),
        (f"{MARKER}:inverted", Board("aruco", 2, 2, 0.2, 0.2, "DICT_4X4_50", True, number=7)),
        (
            "charuco:5x4:0.05/0.03:DICT_4X4_50:legacy:inverted",
            Board("charuco", 5, 4, 0.05, 0.03, "DICT_4X4_50", True, True),
        ),
    ],
)
def test_board_is_read_from_its_name(text: str, board: Board) -> None:
    assert parse_board(text) == board


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("circles:4x4:1", 'no pattern "circles"'),
        ("chessboard:9x6", "has 2 properties, not 1"),
        ("chessboard:9:0.02", "9 is no COLUMNSxROWS"),
        ("chessboard:2x6:0.02", "2x6 is no COLUMNSxROWS"),
        ("chessboard:9x6:25mm", "25mm is no length"),
        ("chessboard:9x6:nan", "nan is no length"),
        ("chessboard:9x6:25", "25 is no length of a square in metres"),
        ("charuco:5x4:0.05:DICT_4X4_49", 'did you mean "DICT_4X4_'),
        ("charuco:5x4:0.05/0.06:DICT_4X4_50", "marker must be smaller"),
        ("aruco:0.2:DICT_4X4_50", "this is no single marker"),
        ("aruco:0.2:DICT_4X4_50:seven", "this is no single marker"),
        ("aruco:0.2:DICT_4X4_50:7:legacy", "this is no single marker"),
        ("aruco:0.2:DICT_4X4_50:50", "DICT_4X4_50 has the markers 0 to 49"),
        ("aruco:20cm:DICT_4X4_50:7", "20cm is no length"),
        ("charuco:5x4:0.05:DICT_4X4_50:upside", "this is no ChArUco board"),
    ],
)
def test_board_that_is_none_is_answered_with_the_form(text: str, complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        parse_board(text)


@pytest.mark.parametrize("text", [CHARUCO, f"{CHARUCO}:inverted", CHESSBOARD])
def test_corners_are_found_to_a_fraction_of_a_pixel(text: str) -> None:
    board, camera = parse_board(text), lens()
    photographer = Photographer(camera, board)
    view = Detector(board).find(photographer.picture(PLACE), 7)
    assert view is not None
    assert view.frame == 7
    assert len(view.label) == len(board.corners)
    error = np.linalg.norm(view.pixel - project(camera, photographer.corners(PLACE))[view.label], axis=1)
    assert np.median(error) < 0.05
    assert error.max() < 0.15
    assert view.blur < 4


@pytest.mark.parametrize("text", [MARKER, f"{MARKER}:inverted"])
def test_corners_of_a_single_marker_are_found(text: str) -> None:
    board, camera = parse_board(text), lens()
    photographer = Photographer(camera, board)
    picture = photographer.picture(PLACE)
    true = project(camera, photographer.corners(PLACE))
    rough, view = Detector(board).find(picture), Detector(board, camera).find(picture, 7)
    assert rough is not None
    assert view is not None
    assert (view.frame, view.label.tolist()) == (7, [0, 1, 2, 3])
    assert np.linalg.norm(rough.pixel - true, axis=1).max() < 1.0
    assert np.linalg.norm(view.pixel - true, axis=1).max() < 0.15
    assert Detector(replace(board, number=8), camera).find(picture) is None
    assert Detector(board).find(np.hstack([picture, picture])) is None


def test_half_hidden_charuco_gives_the_corners_that_are_seen() -> None:
    board, camera = parse_board(CHARUCO), lens()
    photographer = Photographer(camera, board)
    picture = photographer.picture(Place((0.0, 0.0, 0.0), (0.0, 0.0, 0.5)))
    picture[:, 420:] = 128
    view = Detector(board).find(picture)
    assert view is not None
    assert 6 <= len(view.label) < len(board.corners)
    expected = project(camera, photographer.corners(Place((0.0, 0.0, 0.0), (0.0, 0.0, 0.5))))[view.label]
    assert np.linalg.norm(view.pixel - expected, axis=1).max() < 0.2


def test_chessboard_begins_at_the_same_corner_when_it_is_turned_around() -> None:
    board, camera = parse_board(CHESSBOARD), lens()
    photographer = Photographer(camera, board)
    for turn in (0.0, 1.5, 3.1, -1.6):
        place = Place((0.0, 0.0, turn), (0.0, 0.0, 0.7))
        view = Detector(board).find(photographer.picture(place))
        assert view is not None
        assert np.linalg.norm(view.pixel - project(camera, photographer.corners(place)), axis=1).max() < 0.5


def test_only_a_chessboard_with_even_or_odd_sides_looks_the_same_after_half_a_turn() -> None:
    assert parse_board("chessboard:8x6:0.02").symmetric
    assert parse_board("chessboard:9x7:0.02").symmetric
    assert not parse_board("chessboard:9x6:0.02").symmetric
    assert not parse_board(CHARUCO).symmetric


def test_motion_blur_is_measured_in_pixels() -> None:
    board = parse_board(CHARUCO)
    sharp = Photographer(lens(), board).picture(Place((0.0, 0.0, 0.0), (0.0, 0.0, 0.5)))
    moved = cv2.blur(sharp, (9, 1))
    views = [Detector(board).find(picture) for picture in (sharp, moved)]
    assert views[0] is not None
    assert views[1] is not None
    assert views[1].blur > 2 * views[0].blur


def test_picture_without_a_board_has_no_view() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (480, 640)).astype("u1")
    for text in (CHARUCO, CHESSBOARD):
        assert Detector(parse_board(text)).find(noise) is None
