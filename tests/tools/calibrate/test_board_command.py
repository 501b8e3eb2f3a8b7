"""`calibrate board` as a user types it."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.board_views import BOARD, apart, standing, unknown
from tests.tools.calibrate.drawn_boards import Photographer, Place

from followspot.cli.main import main
from followspot.errors import InputError
from followspot.room import Room
from followspot.room_file import load, save
from followspot_calibrate.board.timestamps import read_timestamps

CALISCOPE = dataset("calib-charuco-4cam-caliscope")
TIMES = "sync_index,cam_id,frame_index,frame_time\n7,0,40,1.0\n7,1,41,1.0\n8,0,41,1.1\n9,1,42,1.2\n"


def test_timestamps_pair_pictures_by_their_order(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(TIMES)
    assert read_timestamps(tmp_path / "t.csv", ["cam_0", "cam_1"]) == {
        "cam_0": {0: 7, 1: 8},
        "cam_1": {0: 7, 1: 9},
    }


def test_timestamps_need_no_frame_numbers(tmp_path: Path) -> None:
    table = "sync_index,cam_id,frame_time\n8,0,1.1\n7,0,1.0\n7,1,1.0\n9,1,1.2\n"
    (tmp_path / "t.csv").write_text(table)
    assert read_timestamps(tmp_path / "t.csv", ["cam0", "cam1"]) == {
        "cam0": {0: 7, 1: 8},
        "cam1": {0: 7, 1: 9},
    }


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("sync_index", "sync", "missing columns: sync_index"),
        ("7,1,41", "7,1,x", r't.csv:3:\d+: "x" in column frame_index'),
        ("7,1,41,1.0\n", "7,1\n", r"t.csv:3:1: 2 columns, 4 needed"),
        ("8,0,41,1.1", "8,0,40,1.1", r"t.csv:4:1: frame_index does not rise from line 2"),
        (",1,4", ",2,4", r"no row of camera cam_1(.|\n)*cam_id"),
    ],
)
def test_mistake_in_timestamps_is_told(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    (tmp_path / "t.csv").write_text(TIMES.replace(old, new))
    with pytest.raises(InputError, match=complaint):
        read_timestamps(tmp_path / "t.csv", ["cam_0", "cam_1"])


PAIR = [
    standing("left", (-0.3, -1.0, 1.0), (0.0, 0, 1.0)),
    standing("right", (0.3, -1.0, 1.0), (0.0, 0, 1.0)),
]


@pytest.fixture(scope="module")
def boards(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures of a board in two cameras."""
    folder = tmp_path_factory.mktemp("boards")
    rng = np.random.default_rng(1)
    photographers = [Photographer(camera, BOARD) for camera in PAIR]
    for camera in PAIR:
        (folder / camera.name).mkdir()
    for moment in range(6):
        R = PAIR[0].rotation.T @ cv2.Rodrigues(rng.uniform(-0.3, 0.3, 3))[0]
        at = np.array([0, -0.1, 1.0]) + rng.uniform(-0.15, 0.15, 3)
        for camera, photographer in zip(PAIR, photographers, strict=True):
            tilt = cv2.Rodrigues(camera.rotation @ R)[0].ravel()
            place = Place(tuple(tilt), tuple(camera.rotation @ at + camera.translation))
            cv2.imwrite(f"{folder}/{camera.name}/{moment}.png", photographer.picture(place))
    return folder


@pytest.fixture
def room(tmp_path: Path, boards: Path) -> Path:
    """The pictures, and a room file that knows the lenses and where the first camera is."""
    (tmp_path / "boards").symlink_to(boards)
    save(Room("r", {camera.name: camera for camera in unknown(PAIR)}), tmp_path / "room.yaml")
    return tmp_path


def calibrate(folder: Path, *more: str, board: str = "charuco:6x5:0.06:DICT_4X4_50") -> int:
    arguments = ["--room", str(folder / "room.yaml"), "--videos", str(folder / "boards"), "--board", board]
    return main(["calibrate", "board", *arguments, *more])


def test_command_writes_the_poses(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert calibrate(room, "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    left, right = load(room / "room.yaml").cameras.values()
    np.testing.assert_allclose(left.center, [-0.3, -1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(right.center, [0.3, -1.0, 1.0], atol=0.005)
    assert answer["rigidity_rmse_mm"] < 1.0
    assert answer["pairs"][0]["shared"] == 6
    assert any("linked by 6 moments only" in note for note in answer["warnings"])
    page = (room / "room.board.html").read_text()
    assert "left – right" in page
    assert "linked by 6 moments only" in page


def test_the_page_goes_where_it_is_asked_to(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = room / "looked_at.html"
    assert calibrate(room, "--report", str(page)) == 0
    assert f"the page to look at: {page}" in capsys.readouterr().out
    assert "arrows ×" in page.read_text()
    assert not (room / "room.board.html").exists()


def test_camera_without_a_recording_keeps_its_pose(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cameras = {camera.name: camera for camera in [*unknown(PAIR), standing("top", (0, 0, 3.0), (0, 1, 0))]}
    save(Room("r", cameras), room / "room.yaml")
    assert calibrate(room) == 0
    np.testing.assert_array_equal(load(room / "room.yaml").cameras["top"].center, cameras["top"].center)
    assert "top has no recording and keeps its pose" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("board", "more", "complaint"),
    [
        ("chessboard:8x6:0.02", [], "ends of this chessboard cannot be told apart"),
        ("charuco:6x5:0.06:DICT_4X4_50", ["--clip", "top=room.yaml"], 'has no camera "top"'),
        ("charuco:6x5:0.06:DICT_4X4_50", ["--pictures", "0"], "--pictures 0 is less than 1"),
        ("charuco:6x5:0.06:DICT_4X4_50", ["--timestamps", "none.csv"], "none.csv cannot be read"),
    ],
)
def test_command_refuses_what_it_cannot_do(
    room: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    board: str,
    more: list[str],
    complaint: str,
) -> None:
    monkeypatch.chdir(room)
    assert calibrate(room, *more, board=board) == 2
    assert complaint in capsys.readouterr().err


def test_recording_of_another_size_is_refused(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cameras = load(room / "room.yaml").cameras
    save(Room("r", {name: replace(c, size=(320, 240)) for name, c in cameras.items()}), room / "room.yaml")
    assert calibrate(room) == 2
    assert "left is calibrated for 320x240 px, its recording is 640x480" in capsys.readouterr().err


@needs_data("calib-charuco-4cam-caliscope")
@pytest.mark.thorough
def test_real_board_is_rigid_to_two_millimetres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Four webcams, 54 mm squares; the poses agree with an earlier calibration by another program."""
    given = tmp_path / "room.yaml"
    assert main(["room", "import", str(CALISCOPE / "camera_array.toml"), "-o", str(given)]) == 0
    before = load(given).cameras
    blank = {n: replace(c, rotation=np.eye(3), translation=np.zeros(3)) for n, c in before.items()}
    save(Room("r", {**blank, "cam_0": before["cam_0"]}), given)
    capsys.readouterr()
    videos = ["--videos", str(CALISCOPE / "calibration/extrinsic"), "--pictures", "40", "--json"]
    board = ["--board", "charuco:4x5:0.054:DICT_4X4_1000:inverted"]
    assert main(["calibrate", "board", "--room", str(given), *videos, *board]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["rigidity_rmse_mm"] < 2.0
    assert answer["distances"] > 500
    after = load(given).cameras
    assert apart(tuple(after.values()), list(before.values())).max() < 0.03
